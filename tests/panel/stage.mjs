// A browser, the simulated daemon, and pages that collect all errors.
import assert from "node:assert/strict";
import { existsSync } from "node:fs";
import { isDeepStrictEqual } from "node:util";
import { startServer } from "./server.mjs";
import { bundle, chromium } from "./sources.mjs";

export const laptop = { width: 1366, height: 768 };
export const phone = { width: 390, height: 844 };

export async function openBrowser() {
    const program = "/usr/bin/chromium";
    assert.ok(existsSync(program), `${program} is missing: .ci/install`);
    const args = process.getuid() === 0 ? ["--no-sandbox"] : [];
    return chromium.launch({ executablePath: program, args, handleSIGTERM: false });
}

export async function setStage() {
    const server = await startServer(bundle);
    const browser = await openBrowser();
    const closePages = () => Promise.all(browser.contexts().map((context) => context.close()));
    return { server, browser, closePages, clear: async () => { await browser.close(); server.close(); } };
}

/** A page that is open and shows the bench. `troubles` collects errors, violations, and requests to other hosts. */
export async function openPage({ server, browser }, { viewport = laptop, hash = "#token=opensesame", ...more } = {}) {
    const context = await browser.newContext({ viewport, ...more });
    const page = await context.newPage();
    const troubles = [], host = `127.0.0.1:${server.port}`;
    page.on("console", (message) => { if (["error", "warning"].includes(message.type())) troubles.push(`console: ${message.text()}`); });
    page.on("pageerror", (error) => troubles.push(`error: ${error.stack}`));
    page.on("request", (request) => { if (new URL(request.url()).host !== host) troubles.push(`request: ${request.url()}`); });
    page.on("websocket", (socket) => { if (new URL(socket.url()).host !== host) troubles.push(`socket: ${socket.url()}`); });
    await page.addInitScript(() => {
        document.addEventListener("securitypolicyviolation", (event) => console.error(`policy: ${event.violatedDirective} ${event.blockedURI}`));
    });
    await page.goto(`http://${host}/${hash}`);
    await page.waitForFunction(() => /idle|armed|running|tripped/.test(document.getElementById("state").textContent));
    return { page, troubles };
}

/** The bench with its drive at full level and results that are steady. */
export async function running({ server }) {
    const { bench } = server;
    bench.control = true;
    if (bench.state === "tripped") bench.act("clear");
    if (bench.state !== "running") {
        bench.act("drive", { gamma_mps2: 9.8, phi_rad: 0, rho: 0.5, frequency_hz: 20 });
        bench.become("running");
    }
    await until(() => bench.level === 1 && bench.periods > 25, "the bench runs");
}

export async function idle({ server }) {
    const { bench } = server;
    bench.control = true;
    bench.trip = null;
    bench.recording = null;
    bench.record_next = false;
    bench.become("idle");
    await until(() => bench.level === 0, "the bench is silent");
}

export async function until(condition, what, patience = 8000) {
    for (const end = Date.now() + patience; !(await condition());) {
        assert.ok(Date.now() < end, `not within ${patience} ms: ${what}`);
        await new Promise((resume) => setTimeout(resume, 20));
    }
}

/** What `look` sees once it sees the same twice, so many ms apart. */
export async function still(look, what, apart = 300) {
    let seen = await look();
    await until(async () => {
        await new Promise((resume) => setTimeout(resume, apart));
        const before = seen;
        seen = await look();
        return isDeepStrictEqual(before, seen);
    }, `${what} stands still`);
    return seen;
}

/** The cameras' pictures are there, if their card is in view. */
export const pictured = (page) => page.waitForFunction(() => {
    const figures = [...document.querySelectorAll("#cameras figure")];
    const shown = figures.length > 0 && figures.every((e) => !e.textContent.includes("no picture yet"));
    return shown || document.getElementById("cameras-card").getBoundingClientRect().top > innerHeight;
});

/** Memory of a page after garbage collection. */
export async function heapOf(page) {
    const devtools = await page.context().newCDPSession(page);
    for (let k = 0; k < 3; k++) await devtools.send("HeapProfiler.collectGarbage");
    const { usedSize, backingStorageSize = 0 } = await devtools.send("Runtime.getHeapUsage");
    const { nodes, jsEventListeners } = await devtools.send("Memory.getDOMCounters");
    await devtools.detach();
    return { bytes: usedSize + backingStorageSize, nodes, jsEventListeners };
}
