// ABORT in headless Chromium: by click and keys, without an answer, and for a daemon that has ended; the lost connection.
import assert from "node:assert/strict";
import { join } from "node:path";
import test, { after, afterEach, before, beforeEach } from "node:test";
import { idle, openPage, phone, running, setStage, still, until } from "./stage.mjs";

const folder = process.env.PANEL_SCREENSHOTS;
let stage, server;
before(async () => {
    stage = await setStage();
    ({ server } = stage);
});
after(() => stage.clear());
afterEach(() => stage.closePages());
beforeEach(async () => {
    server.refuse = null;
    server.silent = false;
    await idle(stage);
    server.requests.length = 0;
});

const last = () => server.requests.at(-1);
const sent = async (name) => {
    await until(() => last()?.name === name, `POST ${name}`);
    return last().body;
};
const aborts = () => server.requests.filter(({ name }) => name === "abort").length;
const press = (page, name) => page.getByRole("button", { name, exact: true }).click();
const isTripped = (page) => page.waitForFunction(() => document.getElementById("state").textContent.includes("tripped"));

test("ABORT by click stops the drive, is confirmed, and needs no control; the trip can be cleared", async () => {
    await running(stage);
    server.bench.control = false;
    const { page, troubles } = await openPage(stage);
    await page.click("#abort");
    await sent("abort");
    assert.equal(last().body, null);
    await isTripped(page);
    await until(() => server.bench.level === 0, "silent");
    await page.locator("#abort-status").getByText(/^ABORT received, \d+ ms$/).waitFor();
    assert.match(await page.locator("#trip-text").textContent(), /stopped by the operator/);
    server.bench.control = true;
    if (folder) await page.screenshot({ path: join(folder, "trip.png") });
    await press(page, "Clear the trip");
    await sent("clear");
    await page.waitForFunction(() => document.getElementById("trip").hidden);
    assert.deepEqual(troubles, []);
});

test("ABORT by Escape works everywhere, also in a field", async () => {
    const { page } = await openPage(stage);
    await page.keyboard.press("Escape");
    await until(() => aborts() === 1, "one");
    await page.focus("#record-name");
    await page.keyboard.press("Escape");
    await until(() => aborts() === 2, "two");
    await isTripped(page);
});

test("Space aborts, even on another button, but not in a text field", async () => {
    const { page } = await openPage(stage);
    await page.focus("#record-name");
    await page.keyboard.type("a b");
    await page.waitForTimeout(200);
    assert.equal(aborts(), 0);
    assert.equal(await page.inputValue("#record-name"), "a b");
    await page.focus("#start button");
    await page.keyboard.press("Space");
    await until(() => aborts() === 1, "abort");
    await page.waitForTimeout(200);
    assert.deepEqual(server.requests.map(({ name }) => name), ["abort"]);
    await page.focus("#abort");
    await page.keyboard.press("Space");
    await until(() => aborts() === 2, "abort on its own button");
    await page.waitForTimeout(200);
    assert.equal(aborts(), 2);
});

test("An output that does not obey ABORT is told until it obeys", async () => {
    await running(stage);
    const { page } = await openPage(stage);
    server.refuse = "the output does not answer: cut the amplifier";
    await page.keyboard.press("Escape");
    await page.waitForFunction(() => /not confirmed: .*cut the amplifier/.test(document.getElementById("abort-status").textContent));
    server.refuse = null;
    await page.waitForFunction(() => /received/.test(document.getElementById("abort-status").textContent));
});

test("ABORT works without the socket and is repeated until it is confirmed", async () => {
    await running(stage);
    const { page } = await openPage(stage);
    server.silent = true;
    server.dropAll();
    await page.waitForFunction(() => document.body.classList.contains("stale"));
    await page.keyboard.press("Escape");
    await until(() => aborts() >= 3, "repeated");
    await page.waitForFunction(() => /not confirmed.*attempt \d/.test(document.getElementById("abort-status").textContent));
    if (folder) await page.screenshot({ path: join(folder, "lost.png") });
    assert.equal(server.bench.state, "running");
    server.silent = false;
    await until(() => server.bench.state === "tripped", "aborted");
    await page.waitForFunction(() => /received/.test(document.getElementById("abort-status").textContent));
    const count = aborts();
    await page.waitForTimeout(1500);
    assert.equal(aborts(), count, "no more of them once it was received");
});

test("1.5 s after an ABORT without an answer a bar over the full width asks for the hardware stop", async () => {
    await running(stage);
    for (const viewport of [{ width: 1366, height: 768 }, phone]) {
        const { page } = await openPage(stage, { viewport });
        server.silent = true;
        server.dropAll();
        await page.locator("#log").scrollIntoViewIfNeeded();
        const bar = page.locator("#hardware-stop");
        const begun = Date.now();
        await page.keyboard.press("Escape");
        await bar.getByText("No answer from the daemon: press the hardware stop NOW").waitFor();
        assert.ok(Date.now() - begun > 1400 && Date.now() - begun < 4000, `${Date.now() - begun} ms`);
        assert.equal(await bar.getAttribute("role"), "alert");
        for (const seen of [bar, page.locator("#link"), page.locator("#abort")]) {
            const box = await seen.boundingBox();
            assert.ok(box.y >= 0 && box.y + box.height <= viewport.height, "seen when scrolled");
        }
        assert.equal((await bar.boundingBox()).width, viewport.width);
        await page.locator("#abort").click({ trial: true });  // not covered
        if (folder) await page.screenshot({ path: join(folder, `hardware-stop-${viewport.width}.png`) });
        server.silent = false;
        await bar.waitFor({ state: "hidden" });
        server.bench.trip = null;
        server.bench.become("running");
        await page.context().close();
    }
});

test("A repeated ABORT names the daemon of its press; another one at rest is told and stays clear", async () => {
    await running(stage);
    const { page } = await openPage(stage);
    server.silent = true;
    server.dropAll();
    await page.keyboard.press("Escape");
    const names = () => server.requests.filter(({ name }) => name === "abort").map(({ daemon }) => daemon);
    await until(() => names().at(-1) !== null, "repeated");
    assert.deepEqual([names()[0], names().at(-1)], [null, server.bench.daemon]);
    await idle(stage);
    server.bench.daemon = "fedcba9876543210";  // another start of the daemon
    server.silent = false;
    await page.locator("#abort-status").getByText(/^ABORT not done: the abort was for a daemon that has ended/).waitFor();
    assert.equal(server.bench.state, "idle");
    assert.ok(await page.locator("#hardware-stop").isHidden());
    await page.keyboard.press("Escape");
    await until(() => server.bench.state === "tripped", "a new press always acts");
    await page.locator("#link").waitFor({ state: "hidden" });
    server.silent = true;
    await idle(stage);
    await page.keyboard.press("Escape");
    await until(() => names().at(-1) === server.bench.daemon, "repeated");
    server.bench.daemon = "0123456789abcdef";
    server.silent = false;
    await page.keyboard.press("Escape");
    await until(() => server.bench.state === "tripped", "also one while another is repeated");
});

test("A lost connection is shown with its time, old values are grey, and the page reconnects", async () => {
    const { page } = await openPage(stage, { viewport: phone });
    const events = await page.locator("#log li").count();
    server.silent = true;
    server.dropAll();
    await page.getByText(/Not connected since \d/).waitFor();
    assert.ok(Number(await page.evaluate(() => getComputedStyle(document.querySelector(".big")).opacity)) < 0.5);
    assert.equal(await page.evaluate(() => document.documentElement.scrollWidth), 390);
    await page.waitForTimeout(1000);
    server.silent = false;
    await page.waitForFunction(() => document.getElementById("link").hidden && !document.body.classList.contains("stale"), null, { timeout: 10_000 });
    await page.locator("#log").scrollIntoViewIfNeeded();
    await until(() => server.subscribed().includes("waveform"), "streams are asked for again");
    const lines = await still(() => page.locator("#log li").count(), "the log");
    assert.ok(Math.abs(lines - server.bench.events.length) <= 1, "the log is not doubled");
    assert.ok(events <= server.bench.events.length);
});

test("An open but silent socket counts as lost", async () => {
    const { page } = await openPage(stage);
    server.mute = true;
    await page.getByText(/Not connected since/).waitFor({ timeout: 6000 });
    const since = await page.locator("#link").textContent();
    await page.waitForTimeout(4000);
    assert.equal(await page.locator("#link").textContent(), since, "it stays so while the daemon says nothing");
    server.mute = false;
    await page.waitForFunction(() => document.getElementById("link").hidden, null, { timeout: 8000 });
});
