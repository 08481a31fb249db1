// The daemon on its simulated bench for PANEL_MINUTES, without pictures: a measurement a second, two pages that show
// everything, and a client that asks for the state ten times a second. Memory, processor time and descriptors of the daemon
// and the memory of the pages stay level. At rest the daemon takes little of a core. The drive's phase is near the null, so
// that the walker stays in the picture.
import assert from "node:assert/strict";
import { readdirSync, readFileSync } from "node:fs";
import { connect } from "node:net";
import test from "node:test";
import { startDaemon } from "./daemon.mjs";
import { heapOf, openBrowser, openPage } from "./stage.mjs";

const minutes = Number(process.env.PANEL_MINUTES ?? 10);
const warm = Math.min(20, minutes / 2);
const idleFor = 4;            // s; the least of three such windows counts, as other programs disturb
const mostIdle = minutes < 10 ? 0.08 : 0.05;  // of a core; a short run has other tests beside it, which make its work dearer
const fullTable = 1000;       // rows; until then the table of results grows, and with it the page
const nullPhase = 2.17;       // rad
const clockTicks = 100;       // a second, in /proc
const poll = 100;             // ms between two requests
/** Allowed growth: a share, and an amount: connections of the poller, and what other programs take of the processor's time. */
const growth = { resident: [0.1, 0], cpu: [0.25, 0.03], descriptors: [0, 3], bytes: [0.1, 0], nodes: [0.1, 0], jsEventListeners: [0.1, 0] };
const ofRows = ["bytes", "nodes", "jsEventListeners"];
const pause = (seconds) => new Promise((resume) => setTimeout(resume, 1e3 * seconds));

const residentOf = (pid) => 4096 * Number(readFileSync(`/proc/${pid}/statm`, "utf8").split(" ")[1]);
const descriptorsOf = (pid) => readdirSync(`/proc/${pid}/fd`).length;

/** Processor time of the daemon, s. */
function cpuOf(pid) {
    const words = readFileSync(`/proc/${pid}/stat`, "utf8").split(") ")[1].split(" ");
    return (Number(words[11]) + Number(words[12])) / clockTicks;
}

/** Share of a core within so many seconds. */
async function shareOf(pid, seconds) {
    const before = cpuOf(pid), begin = performance.now();
    await pause(seconds);
    return (cpuOf(pid) - before) / ((performance.now() - begin) / 1e3);
}

/** Asks for the state until it is ended, one question at a time: the daemon closes the quietest of more than 32 connections. */
function startPoller(port) {
    const poller = { answered: 0, failures: [], end: () => clearInterval(timer) };
    let open = false;
    const ask = async () => {
        if (open) return;
        open = true;
        const asked = performance.now();
        try {
            const response = await fetch(`http://127.0.0.1:${port}/api/state`);
            if (!response.ok) throw new Error(`status ${response.status}: ${await response.text()}`);
            await response.json();
            poller.answered++;
        } catch (trouble) {
            poller.failures.push(`${trouble.message} ${trouble.cause?.code ?? ""} after ${Math.round(performance.now() - asked)} ms`);
        } finally {
            open = false;
        }
    };
    const timer = setInterval(() => void ask(), poll);
    return poller;
}

test(`After ${minutes} min with a measurement a second, daemon and pages are as after ${warm.toFixed(2)} min`, async () => {
    const daemon = await startDaemon(nullPhase, "[top]\npositions = 1\nframe_rate_hz = 200\n[side]\npositions = 1\nframe_rate_hz = 200\n");
    const { pid } = daemon.child;
    const stage = { server: { port: daemon.port }, browser: await openBrowser() };
    let poller = null;
    try {
        const state = async () => (await (await fetch(`http://127.0.0.1:${daemon.port}/api/state`)).json());
        const order = (name, body = {}) => fetch(`http://127.0.0.1:${daemon.port}/api/${name}`, { method: "POST", body: JSON.stringify(body) });
        while ((await state()).session?.state !== "idle") await pause(0.1);
        const idle = Math.min(await shareOf(pid, idleFor), await shareOf(pid, idleFor), await shareOf(pid, idleFor));
        const pages = await Promise.all([0, 1].map(() => openPage(stage, { hash: "", viewport: { width: 1366, height: 2000 } })));
        poller = startPoller(daemon.port);
        assert.equal((await order("start", { periods: 20 })).status, 200);
        while ((await state()).session.state !== "running") await pause(0.1);
        const window = Math.min(60, 20 * minutes);  // s, for the processor time
        const look = async () => {
            const cpu = await shareOf(pid, window), heaps = [];
            for (const { page } of pages) heaps.push(await heapOf(page));
            const most = (key) => Math.max(...heaps.map((heap) => heap[key]));
            return { resident: residentOf(pid), cpu, descriptors: descriptorsOf(pid), bytes: most("bytes"), nodes: most("nodes"), jsEventListeners: most("jsEventListeners") };
        };
        await pause(Math.max(0, 60 * warm - window));
        const early = await look(), first = (await state()).result.number;
        await pause(Math.max(0, 60 * (minutes - warm) - window));
        const late = await look(), measured = (await state()).result.number - first;
        console.log(`# at rest ${(100 * idle).toFixed(1)} % of a core; ${poller.answered} answers; ${measured} measurements`);
        console.log(`# after ${warm.toFixed(2)} min ${JSON.stringify(early)}, after ${minutes} min ${JSON.stringify(late)}`);
        assert.ok(idle < mostIdle, `at rest ${idle} of a core`);
        assert.equal((await state()).session.state, "running");
        assert.ok(measured > 0.8 * 60 * (minutes - warm), `${measured} measurements`);
        assert.ok(poller.answered > 0.8 * 600 * minutes, `${poller.answered} answers`);
        assert.deepEqual(poller.failures, []);
        for (const [key, [share, amount]] of Object.entries(growth))
            if (!ofRows.includes(key) || first >= fullTable) assert.ok(late[key] <= (1 + share) * early[key] + amount, `${key}: ${early[key]} then ${late[key]}`);
        for (const { troubles } of pages) assert.deepEqual(troubles, []);
    } finally {
        poller?.end();
        await stage.browser.close();
        await daemon.end();
    }
});

const cycleMinutes = minutes / 4;

// Every way a drive ends, again and again: a stop, an abort by HTTP, an abort by SCPI; every seventh run is recorded.
test(`After ${cycleMinutes} min of starts, stops, aborts and clears the daemon is as at the beginning`, async () => {
    const daemon = await startDaemon(nullPhase, "[top]\npositions = 1\nframe_rate_hz = 200\n[side]\npositions = 1\nframe_rate_hz = 200\n");
    const { pid } = daemon.child;
    let poller = null;
    try {
        const state = async () => (await (await fetch(`http://127.0.0.1:${daemon.port}/api/state`)).json());
        const order = async (name, body = {}) => {
            const answer = await fetch(`http://127.0.0.1:${daemon.port}/api/${name}`, { method: "POST", body: JSON.stringify(body) });
            assert.equal(answer.status, 200, `${name}: ${await answer.text()}`);
        };
        const until = async (...words) => {
            for (const late = Date.now() + 20_000; ; await pause(0.02)) {
                const now = await state();
                if (words.includes(now.session?.state) && !(words[0] === "tripped" && !now.session.may_clear)) return;
                assert.ok(Date.now() < late, `${now.session?.state}, not ${words}`);
            }
        };
        const abortByScpi = () => new Promise((resume, fail) => {
            const socket = connect(daemon.scpi, "127.0.0.1", () => socket.write("ABOR?\n"));
            socket.once("data", (answer) => { socket.destroy(); String(answer).trim() === "1" ? resume() : fail(new Error(`ABOR? answered ${answer}`)); });
            socket.once("error", fail);
        });
        await until("idle");
        poller = startPoller(daemon.port);
        const aborts = [], looks = [], look = () => ({ resident: residentOf(pid), descriptors: descriptorsOf(pid) });
        let cycles = 0;
        for (const begin = Date.now(); Date.now() < begin + 6e4 * cycleMinutes || cycles < 8; cycles++) {
            await order("drive", { gamma_mps2: 5 + (cycles % 3) });
            if (cycles % 7 === 0) await order("record", { on: true, name: `cycle${cycles}`, frames: "off" });
            await order("start", { periods: 10 });
            await until("identifying", "checking", "ramping", "settling", "running");
            await pause(0.1 + 0.5 * (cycles % 5));
            if (cycles % 3 === 0) {
                await order("stop");
            } else {
                const asked = performance.now();
                await (cycles % 3 === 1 ? order("abort") : abortByScpi());
                aborts.push(performance.now() - asked);
                await until("tripped");
                await order("clear");
            }
            await until("idle");
            if (cycles >= 4) looks.push(look());
        }
        aborts.sort((a, b) => a - b);
        const [early, late] = [looks[Math.floor(looks.length / 2)], looks.at(-1)];
        console.log(`# ${cycles} cycles; ${aborts.length} aborts, ms: median ${aborts[aborts.length >> 1].toFixed(1)}, largest ${aborts.at(-1).toFixed(1)}; ${poller.answered} states`);
        console.log(`# half: ${JSON.stringify(early)}, end: ${JSON.stringify(late)}`);
        assert.ok(aborts[Math.floor(0.99 * aborts.length)] < 250, `aborts took ${aborts.slice(-3)} ms`);
        assert.ok(late.resident < 1.05 * early.resident, "memory");
        assert.ok(late.descriptors <= early.descriptors + 3, "descriptors");
        assert.deepEqual(poller.failures, []);
    } finally {
        poller?.end();
        await daemon.end();
    }
});
