// Hours of streaming must not increase the page's memory. PANEL_MINUTES: duration; the first third, at most a minute,
// fills its buffers.
import assert from "node:assert/strict";
import test from "node:test";
import { heapOf, openPage, running, setStage } from "./stage.mjs";

const minutes = Number(process.env.PANEL_MINUTES ?? 1);
const warm = Math.min(1, minutes / 3);
const wait = (m) => new Promise((resume) => setTimeout(resume, m * 60_000));

test(`After ${minutes} min of streaming its memory is within 10 % of that after ${warm.toFixed(2)} min`, async (t) => {
    const stage = await setStage();
    t.after(() => stage.clear());
    const { server } = stage;
    await running(stage);
    const { page, troubles } = await openPage(stage, { viewport: { width: 1366, height: 2000 } });
    // Ten events per second fill the log before the first measurement of memory; otherwise its growth would be normal.
    for (let k = 0; k < 600; k++) server.bench.log("info", `event before the first look ${k}`);
    const chatter = setInterval(() => server.bench.log("info", `event at ${server.bench.time}`), 100);
    t.after(() => clearInterval(chatter));
    // The least of three looks: what the collector has not yet freed is no growth.
    const look = async () => {
        let least = await heapOf(page);
        for (let k = 0; k < 2; k++) {
            await wait(1 / 60);
            const now = await heapOf(page);
            for (const key of Object.keys(least)) least[key] = Math.min(least[key], now[key]);
        }
        return least;
    };
    await wait(warm);
    const early = await look();
    await wait(minutes - warm);
    const late = await look();
    console.log(`# after ${warm.toFixed(2)} min ${JSON.stringify(early)}, after ${minutes} min ${JSON.stringify(late)}`);
    for (const key of Object.keys(early)) assert.ok(Math.abs(late[key] / early[key] - 1) <= 0.1, `${key}: ${early[key]} then ${late[key]}`);
    assert.deepEqual(troubles, []);
});
