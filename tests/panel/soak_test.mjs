// The daemon drives its simulated bench for PANEL_MINUTES with a page that shows everything: the memory of neither may
// grow. The drive's phase is near the null, so that the walker stays in the picture.
import assert from "node:assert/strict";
import { readFileSync } from "node:fs";
import test from "node:test";
import { startDaemon } from "./daemon.mjs";
import { heapOf, openBrowser, openPage } from "./stage.mjs";

const minutes = Number(process.env.PANEL_MINUTES ?? 10);
const warm = Math.min(1, minutes / 3);
const nullPhase = 2.17;  // rad
const wait = (m) => new Promise((resume) => setTimeout(resume, m * 60_000));

test(`After ${minutes} min of driving, page and daemon are within 10 % of what they were after ${warm.toFixed(2)} min`, async () => {
    const daemon = await startDaemon(nullPhase);
    const stage = { server: { port: daemon.port }, browser: await openBrowser() };
    try {
        const { page, troubles } = await openPage(stage, { hash: "", viewport: { width: 1366, height: 2000 } });
        const stateIs = (word) => page.waitForFunction((w) => document.getElementById("state").textContent.includes(w), word, { timeout: 60_000 });
        await stateIs("idle");
        await page.getByRole("button", { name: "Take control", exact: true }).click();
        await page.getByRole("button", { name: "Start", exact: true }).click();
        await stateIs("running");
        const resident = () => 4096 * Number(readFileSync(`/proc/${daemon.child.pid}/statm`, "utf8").split(" ")[1]);
        const look = async () => ({ ...(await heapOf(page)), daemon: resident() });
        await wait(warm);
        const early = await look();
        await wait(minutes - warm);
        await stateIs("running");  // all the time, and still
        const late = await look();
        console.log(`# after ${warm.toFixed(2)} min ${JSON.stringify(early)}, after ${minutes} min ${JSON.stringify(late)}`);
        for (const key of Object.keys(early)) assert.ok(late[key] / early[key] <= 1.1, `${key}: ${early[key]} then ${late[key]}`);
        assert.deepEqual(troubles, []);
    } finally {
        await stage.browser.close();
        await daemon.end();
    }
});
