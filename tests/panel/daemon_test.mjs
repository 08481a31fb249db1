// The page with the real daemon on the simulated bench: actions of an operator in a real browser.
import assert from "node:assert/strict";
import { createServer, request as forward } from "node:http";
import { connect } from "node:net";
import { join } from "node:path";
import test, { after, before } from "node:test";
import { startDaemon } from "./daemon.mjs";
import { openBrowser, openPage, until } from "./stage.mjs";

const folder = process.env.PANEL_SCREENSHOTS;
let daemon, stage;

before(async () => {
    daemon = await startDaemon(1.75);  // a slow walker, which needs seconds to reach the edge
    stage = { server: { port: daemon.port }, browser: await openBrowser() };
});
after(async () => {
    await stage?.browser.close();
    await daemon?.end();
});

const state = (page) => page.textContent("#state");
const stateIs = (page, word, patience = 30_000) =>
    page.waitForFunction((w) => document.getElementById("state").textContent.includes(w), word, { timeout: patience });
const press = (page, name) => page.getByRole("button", { name, exact: true }).click();

test("A run from the page: drive, start, results, stop, start, abort, clear", { timeout: 240_000 }, async () => {
    const { page, troubles } = await openPage(stage, { hash: "", viewport: { width: 1366, height: 1800 } });
    await stateIs(page, "idle");
    await press(page, "Take control");
    await page.fill("#drive-gamma", "0.8");
    await press(page, "Set and arm");
    await stateIs(page, "armed");
    await page.selectOption("#how-long", "open");
    await press(page, "Start");
    await stateIs(page, "running", 60_000);
    await page.waitForFunction(() => /±/.test(document.getElementById("numbers").textContent), null, { timeout: 60_000 });
    if (folder) await page.screenshot({ path: join(folder, "daemon-running.png"), fullPage: true });
    await press(page, "Stop");
    await stateIs(page, "idle");
    await press(page, "Start");
    await stateIs(page, "running", 60_000);
    await page.keyboard.press("Escape");
    await stateIs(page, "tripped");
    if (folder) await page.screenshot({ path: join(folder, "daemon-tripped.png"), fullPage: true });
    await page.waitForTimeout(1500);
    assert.match(await state(page), /tripped/);
    await press(page, "Clear the trip");
    await stateIs(page, "idle");
    await press(page, "Release control");
    assert.deepEqual(troubles, []);
});

test("Orders without a form of their own are made from the daemon's table", { timeout: 60_000 }, async () => {
    const { page, troubles } = await openPage(stage, { hash: "", viewport: { width: 1366, height: 1200 } });
    await stateIs(page, "idle");
    await page.getByText("More orders").click();
    const loop = page.locator("#orders form[data-action=loop]"), limit = page.locator("#orders form[data-action=limit]");
    const said = (form, pattern) => page.waitForFunction(([name, source]) => new RegExp(source).test(
        document.querySelector(`#orders form[data-action=${name}] output`).textContent), [form, pattern], { timeout: 10_000 });
    await loop.locator("select").selectOption("off");
    await loop.locator("button").click();
    await said("loop", "^✓");
    await limit.locator("select").first().selectOption("transverse");
    await limit.locator("input").fill("90 %");
    await limit.locator("button").click();
    await said("limit", "at most the present 0.5 is allowed; only the settings file can loosen limits");
    await limit.locator("input").fill("49 %");
    await limit.locator("button").click();
    await said("limit", "^✓");
    if (folder) await page.screenshot({ path: join(folder, "daemon-orders.png"), fullPage: true });
    await loop.locator("select").selectOption("on");
    await loop.locator("button").click();
    await said("loop", "^✓");
    assert.deepEqual(await page.locator("#orders form").evaluateAll((forms) => forms.map((form) => form.dataset.action)), ["loop", "limit"]);
    assert.deepEqual(troubles.filter((trouble) => !trouble.includes("409")), []);
});

test("A scan from the page is measured without a person, paused and resumed", { timeout: 240_000 }, async () => {
    const { page, troubles } = await openPage(stage, { hash: "", viewport: { width: 1440, height: 1000 } });
    await stateIs(page, "idle");
    const words = (pattern) => page.waitForFunction((source) => new RegExp(source).test(document.getElementById("campaign-words").textContent), pattern, { timeout: 120_000 });
    await page.fill("#scan-from", "98");
    await page.fill("#scan-to", "102");
    await page.fill("#scan-steps", "1");
    await page.fill("#scan-periods", "5");
    await press(page, "Check the scan");
    await page.waitForFunction(() => /^Check of scan: 2 points, 2 fit; bench time /.test(document.getElementById("plan-check").textContent), null, { timeout: 20_000 });
    await press(page, "Measure the scan");
    await words("measuring: 0 of 2");
    await press(page, "Pause");
    await words("^paused");
    await stateIs(page, "idle", 60_000);
    if (folder) await page.screenshot({ path: join(folder, "daemon-campaign.png"), fullPage: true });
    await press(page, "Resume");
    await words("^ended: 2 of 2 points");
    const report = await page.getByRole("link", { name: "Open the report" }).getAttribute("href", { timeout: 60_000 });
    const answer = await page.request.get(new URL(report, page.url()).href);
    assert.equal(answer.status(), 200);
    assert.match(answer.headers()["content-security-policy"], /^sandbox;/);
    assert.match(await answer.text(), /Efficient transport controlled by biharmonic frictional driving/);
    await page.fill("#log-search", "campaign v_D");
    await page.waitForFunction(() => document.querySelectorAll("#log li:not([hidden])").length === 2, null, { timeout: 10_000 });
    assert.deepEqual(troubles, []);
});

test("A typed comma and an edit that was not sent are driven as shown", { timeout: 240_000 }, async () => {
    const own = await startDaemon(1.75);
    const { page, troubles } = await openPage({ server: { port: own.port }, browser: stage.browser }, { hash: "", viewport: { width: 1366, height: 1800 } });
    try {
        await stateIs(page, "idle");
        await page.fill("#drive-gamma", "200");
        await press(page, "Start");
        await page.locator("#start .answer").getByText("allowed: 0.00102041 to 100 g").waitFor();
        assert.equal(troubles.splice(0).length, 1, "the browser reports the refusal");
        await page.fill("#drive-gamma", "0,5");
        await page.locator("#drive-note").getByText("will be sent: 0.5 g").waitFor();
        await page.selectOption("#how-long", "open");
        await press(page, "Start");
        await stateIs(page, "settling", 60_000);
        const { drive } = await (await page.request.get(new URL("/api/state", page.url()).href)).json();
        assert.ok(Math.abs(drive.gamma_mps2 - 4.9) < 1e-12, String(drive.gamma_mps2));
        await press(page, "Stop");
        await stateIs(page, "idle");
        assert.deepEqual(troubles, []);
    } finally {
        await page.context().close();
        await own.end();
    }
});

test("An ABORT for a killed daemon leaves the next one clear; a new press stops it", { timeout: 240_000 }, async () => {
    const first = await startDaemon(1.75);
    const own = { server: { port: first.port }, browser: stage.browser };
    const { page } = await openPage(own, { hash: "" });
    await page.locator("#log").scrollIntoViewIfNeeded();
    const gone = new Promise((resume) => first.child.on("exit", resume));
    first.child.kill("SIGKILL");
    await gone;
    await page.keyboard.press("Escape");
    await page.locator("#hardware-stop").getByText("No answer from the daemon: press the hardware stop NOW").waitFor();
    if (folder) await page.screenshot({ path: join(folder, "daemon-killed.png") });
    const second = await startDaemon(1.75, "", first.port);
    try {
        await page.locator("#abort-status").getByText(/^ABORT not done: the abort was for a daemon that has ended/).waitFor();
        assert.ok(await page.locator("#hardware-stop").isHidden());
        await stateIs(page, "idle");
        assert.doesNotMatch(second.said(), /abort/);
        await page.keyboard.press("Escape");
        await stateIs(page, "tripped");
    } finally {
        await page.context().close();
        await second.end();
    }
});

/** Answers of the instrument port to lines. */
function scpi(lines) {
    return new Promise((resume, fail) => {
        const socket = connect(daemon.scpi, "127.0.0.1", () => socket.write(lines));
        socket.once("data", (bytes) => { socket.destroy(); resume(bytes.toString()); });
        socket.once("error", fail);
    });
}

test("Behind a proxy with a path the page is whole: files, orders, live data", { timeout: 60_000 }, async () => {
    const inner = (url) => url.replace(/^\/lab\/shaker/, "");
    const proxy = createServer((request, answer) => {
        if (!request.url.startsWith("/lab/shaker/")) return answer.writeHead(404).end();
        request.pipe(forward({ host: "127.0.0.1", port: daemon.port, path: inner(request.url), method: request.method, headers: request.headers },
            (got) => got.pipe(answer.writeHead(got.statusCode, got.headers))));
    });
    proxy.on("upgrade", (request, socket) => {
        const to = connect(daemon.port, "127.0.0.1", () => {
            const lines = Object.entries(request.headers).map(([key, value]) => `${key}: ${value}\r\n`);
            to.write(`GET ${inner(request.url)} HTTP/1.1\r\n${lines.join("")}\r\n`);
            socket.pipe(to).pipe(socket);
        });
        for (const end of [socket, to]) end.on("error", () => { socket.destroy(); to.destroy(); });
    });
    after(() => { proxy.closeAllConnections(); proxy.close(); });
    await new Promise((resume) => proxy.listen(0, "127.0.0.1", resume));
    const page = await (await stage.browser.newContext()).newPage();
    const missed = [];
    page.on("response", (answer) => { if (answer.status() >= 400) missed.push(answer.url()); });
    await page.goto(`http://127.0.0.1:${proxy.address().port}/lab/shaker/`);
    await stateIs(page, "idle");
    await press(page, "Take control");
    await page.fill("#drive-gamma", "0.6");
    await press(page, "Set and arm");
    await stateIs(page, "armed");
    assert.deepEqual(missed, []);
    await press(page, "Release control");
    await page.context().close();
});

test("A page of another site starts nothing, by no door", { timeout: 60_000 }, async () => {
    const before = daemon.said().length;
    const site = createServer((_, answer) => answer.end("<!doctype html>another site"));
    after(() => { site.closeAllConnections(); site.close(); });
    await new Promise((resume) => site.listen(0, "127.0.0.1", resume));
    const page = await (await stage.browser.newContext()).newPage();
    await page.goto(`http://127.0.0.1:${site.address().port}/`);
    const orders = "SYST:LOCK:REQ?\nOUTP:PROT:CLE\nACC 3\nOUTP ON\nABOR\n";
    const tried = await page.evaluate(async ({ http, instrument, orders }) => {
        const send = (url, body, more = {}) => fetch(url, { method: "POST", mode: "no-cors", body, ...more }).then(() => "answered", () => "failed");
        const got = [];
        for (const host of ["127.0.0.1", "localhost"]) {
            for (const path of ["", "OUTP%20ON", "a\n"]) got.push(await send(`http://${host}:${instrument}/${path}`, orders));
            got.push(await send(`http://${host}:${instrument}/`, new Blob([orders])), await send(`http://${host}:${instrument}/`, new URLSearchParams({ a: orders })));
            got.push(await fetch(`http://${host}:${instrument}/`, { mode: "no-cors" }).then(() => "answered", () => "failed"));
            got.push(await new Promise((resume) => { const socket = new WebSocket(`ws://${host}:${instrument}/`); socket.onerror = () => resume("failed"); socket.onopen = () => resume("answered"); }));
            for (const name of ["start", "abort", "identify"]) await send(`http://${host}:${http}/api/${name}`, "{}");
            await new Promise((resume) => { const socket = new WebSocket(`ws://${host}:${http}/ws`); socket.onerror = resume; socket.onopen = () => { socket.send('{"type":"abort"}'); resume(); }; });
            navigator.sendBeacon(`http://${host}:${instrument}/`, orders);
        }
        return got;
    }, { http: daemon.port, instrument: daemon.scpi, orders });
    assert.deepEqual([...new Set(tried)], ["failed"], "the instrument port answers no browser");
    await page.waitForTimeout(500);
    assert.equal(await scpi("SYST:STAT?;:OUTP?;:OUTP:PROT:TRIP?\n"), '"idle";0;0\n');
    await until(() => /SCPI connection of 127\.0\.0\.1:\d+ was closed: it spoke HTTP/.test(daemon.said()), "the log tells why");
    assert.doesNotMatch(daemon.said().slice(before), /order: /);
    await page.context().close();
});
