// The page in headless Chromium: orders that it sends, and behaviour after failures.
import assert from "node:assert/strict";
import { join } from "node:path";
import test, { after, afterEach, before, beforeEach } from "node:test";
import { idle, openPage, running, setStage, until } from "./stage.mjs";

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
const press = (page, name) => page.getByRole("button", { name, exact: true }).click();
const isTripped = (page) => page.waitForFunction(() => document.getElementById("state").textContent.includes("tripped"));
const refusal = /Failed to load resource/;

test("The drive form sends edited fields as typed, with their units, and with the token", async () => {
    const { page, troubles } = await openPage(stage);
    await until(async () => (await page.inputValue("#drive-gamma")) === "1", "the field follows the drive");
    await page.fill("#drive-gamma", "1.5");
    await page.fill("#drive-phi", "35");
    await press(page, "Set and arm");
    const body = await sent("drive");
    assert.deepEqual(Object.keys(body), ["gamma_mps2", "phi_rad"]);
    assert.deepEqual(body, { gamma_mps2: "1.5 g", phi_rad: "35 deg" });
    assert.equal(last().token, "opensesame");
    await page.waitForFunction(() => document.getElementById("state").textContent.includes("armed"));
    await page.selectOption("#drive-gamma-unit", "m/s^2");
    assert.equal(await page.inputValue("#drive-gamma"), "14.7");
    await page.fill("#drive-rho", "0.4");
    await page.press("#drive-rho", "Enter");
    assert.deepEqual(await sent("drive").then(() => until(() => last().body.rho, "rho")).then(() => last().body), { rho: "0.4" });
    assert.deepEqual(troubles, []);
});

test("A decimal comma is sent as typed and stands in words beside the form", async () => {
    const { page, troubles } = await openPage(stage);
    await page.fill("#drive-gamma", "0,5");
    await page.fill("#drive-phi", "0,61 rad");
    await page.locator("#drive-note").getByText("will be sent: 0.5 g, 0.61 rad").waitFor();
    if (folder) await page.screenshot({ path: join(folder, "comma.png") });
    await press(page, "Set and arm");
    assert.deepEqual(await sent("drive"), { gamma_mps2: "0,5 g", phi_rad: "0,61 rad" });
    await until(() => Math.abs(server.bench.drive.gamma_mps2 - 4.9) < 1e-9, "half a g");
    await until(async () => (await page.inputValue("#drive-gamma")) === "0.5", "the field follows");
    await page.fill("#mu-value", "0,113");
    await page.locator("#give-mu .will").getByText("will be sent: 0.113").waitFor();
    await page.press("#mu-value", "Enter");
    assert.deepEqual(await sent("mu"), { mu: "0,113" });
    await page.fill("#scan-to", "3,5");
    await page.locator("#scan .will").getByText("will be sent: 0 deg to 3.5 deg").waitFor();
    assert.deepEqual(troubles, []);
});

test("Start sends the edited drive with the run, or neither is done", async () => {
    const { page } = await openPage(stage);
    await page.fill("#drive-gamma", "0.8");
    await page.fill("#drive-phi", "180");
    await page.locator("#start .will").getByText("will be sent first: 0.8 g, 180 deg").waitFor();
    assert.ok(await page.locator("#start-button").evaluate((e) => e.classList.contains("primary")));
    if (folder) await page.screenshot({ path: join(folder, "unsent.png") });
    await press(page, "Start");
    assert.deepEqual(await sent("start"), { gamma_mps2: "0.8 g", phi_rad: "180 deg", measurements: 3, periods: 20 });
    await until(() => Math.abs(server.bench.drive.gamma_mps2 - 7.84) < 1e-9 && server.bench.state !== "idle", "driven as typed");
    await until(async () => !(await page.locator("#drive-gamma").evaluate((e) => e.classList.contains("edited"))), "sent");
    assert.equal(await page.locator("#start .will").textContent(), "");
    await idle(stage);
    await page.fill("#drive-gamma", "50");
    await press(page, "Start");
    await page.locator("#start .answer").getByText("gamma_mps2 = 490").waitFor();
    assert.equal(server.bench.state, "idle");
    assert.ok(await page.locator("#drive-gamma").evaluate((e) => e.classList.contains("edited")), "kept");
    await page.fill("#drive-gamma", "0.9");
    await page.fill("#measurements", "2");
    assert.equal(await page.locator("#start .answer").textContent(), "", "typing clears the refusal");
});

test("An edited field keeps its value until it is sent or reverted", async () => {
    const { page } = await openPage(stage);
    await page.fill("#drive-frequency", "33");
    server.bench.act("drive", { frequency_hz: 25, gamma_mps2: 14.7 });
    await until(async () => (await page.inputValue("#drive-gamma")) === "1.5", "the other field follows the drive");
    assert.equal(await page.inputValue("#drive-frequency"), "33");
    await press(page, "Revert");
    assert.equal(await page.inputValue("#drive-frequency"), "25");
    server.bench.act("drive", { frequency_hz: 20, gamma_mps2: 9.8 });
    await until(async () => (await page.inputValue("#drive-frequency")) === "20", "it follows again");
});

test("Each button sends its action, from arming to a stop", async () => {
    server.bench.control = false;
    const { page, troubles } = await openPage(stage);
    await press(page, "Take control");
    assert.deepEqual(await sent("control/request"), {});
    await page.getByText("You have control").waitFor();
    await press(page, "Set and arm");
    assert.deepEqual(Object.keys(await sent("drive")).sort(), ["frequency_hz", "gamma_mps2", "phi_rad", "rho"]);
    await press(page, "Identify");
    assert.deepEqual(await sent("identify"), {});
    await until(() => server.bench.state === "armed", "identified");
    await page.fill("#record-name", "  walk ");
    await page.selectOption("#record-frames", "full");
    await press(page, "Record");
    assert.deepEqual(await sent("record"), { name: "walk", frames: "full" });
    await page.getByText("next run is recorded: walk.nxs").waitFor();
    await page.fill("#periods", "40");
    await press(page, "Start");
    assert.deepEqual(await sent("start"), { periods: 40, measurements: 3 });
    await page.waitForFunction(() => document.getElementById("state").textContent.includes("running"));
    await page.getByText("recording walk.nxs").first().waitFor();
    await press(page, "Stop");
    assert.deepEqual(await sent("stop"), {});
    await press(page, "Write it down");
    await page.getByText("remark: needed").waitFor();
    await page.fill("#remark-text", " new paper ");
    await press(page, "Write it down");
    assert.deepEqual(await sent("remark"), { text: "new paper" });
    await until(async () => (await page.inputValue("#remark-text")) === "", "emptied");
    await press(page, "End the recording");
    assert.equal((await sent("record")).name, null);
    await until(() => server.bench.state === "idle", "stopped");
    await press(page, "Release control");
    assert.deepEqual(await sent("control/release"), {});
    await page.getByText("Control is free").waitFor();
    assert.deepEqual(troubles, []);
});

test("A requested recording is shown and can be cancelled; an existing name is refused at once", async () => {
    const { page } = await openPage(stage);
    const chip = page.locator("#recording"), button = page.locator("#record-button");
    assert.equal(await chip.isHidden(), true);
    await page.fill("#record-name", "taken");
    await button.click();
    await page.locator("#record .answer").getByText("/var/lib/shakerd/taken.nxs: exists already").waitFor();
    assert.equal(await chip.isHidden(), true);
    await page.fill("#record-name", "walk");
    await button.click();
    await chip.getByText("○ next run is recorded: walk.nxs").waitFor();
    // Chip and form are drawn at different rates.
    await page.fill("#record-name", "taken");
    await page.press("#record-name", "Enter");
    await page.locator("#record .answer").getByText("/var/lib/shakerd/taken.nxs: exists already").waitFor();
    await chip.getByText("○ next run is recorded: walk.nxs").waitFor();
    await page.fill("#record-name", "another");
    await page.press("#record-name", "Tab");
    await chip.getByText("○ next run is recorded: another.nxs").waitFor();
    await page.getByRole("button", { name: "Do not record" }).click();
    await until(() => chip.isHidden(), "no run is recorded");
    await until(async () => (await button.textContent()) === "Record", "a recording can be requested again");
});

test("A new set-point during a run is played", async () => {
    await running(stage);
    const { page } = await openPage(stage);
    await page.fill("#drive-gamma", "2");
    await press(page, "Set the drive");
    await until(() => server.bench.drive.gamma_mps2 === 19.6, "gamma");
    await until(async () => Number((await page.locator("#v-D").textContent()).split(" ±")[0]) > 30, "v_D at 2 g");
});

test("A refusal is shown below its button until the next press elsewhere", async () => {
    const { page, troubles } = await openPage(stage);
    await page.fill("#drive-frequency", "500");
    await press(page, "Set and arm");
    const answer = page.locator("#drive output");
    await page.getByText("frequency_hz = 500: allowed 1 to 200").waitFor();
    assert.equal(await answer.textContent(), "frequency_hz = 500: allowed 1 to 200");
    assert.equal(await page.locator("#start output").textContent(), "");
    if (folder) await page.screenshot({ path: join(folder, "refusal.png") });
    await press(page, "Start");
    await until(async () => /frequency_hz = 500/.test(await page.locator("#start output").textContent()), "the other form");
    assert.equal(await answer.textContent(), "", "gone");
    await page.click("#start label");
    assert.match(await page.locator("#start output").textContent(), /frequency_hz = 500/, "a press in its form keeps it");
    await page.fill("#drive-frequency", "21");
    await press(page, "Set and arm");
    await until(async () => server.bench.drive.frequency_hz === 21, "the corrected frequency");
    assert.equal(await answer.textContent() === "" || await answer.getAttribute("data-kind") !== "error", true);
    assert.ok(troubles.every((trouble) => refusal.test(trouble)), troubles.join());
});

test("A run until stopped is ordered at once after that choice, before the page has drawn again", async () => {
    const { page } = await openPage(stage);
    await page.evaluate(() => {
        document.getElementById("how-long").value = "open";
        document.getElementById("start-button").click();
    });
    assert.equal((await sent("start")).measurements, 0);
});

test("Invalid numbers are refused without a request to the daemon", async () => {
    const { page } = await openPage(stage);
    const set = page.locator("#drive-set"), start = page.locator("#start-button");
    await page.fill("#drive-rho", "");
    await page.locator("#drive-note").getByText("rho: a number is needed").waitFor();
    assert.deepEqual([await set.isDisabled(), await start.isDisabled()], [true, true]);
    await page.fill("#drive-rho", "1,234,567");
    await page.locator("#drive-note").getByText('rho: "1,234,567" is not a number').waitFor();
    await page.press("#drive-rho", "Enter");
    await press(page, "Revert");
    assert.deepEqual([await set.isDisabled(), await start.isDisabled()], [false, false]);
    await page.fill("#periods", "2.5");
    await page.locator("#start .will").getByText("periods: a whole number from 3").waitFor();
    assert.ok(await start.isDisabled());
    await page.fill("#periods", "");
    await page.fill("#measurements", "0");
    await page.locator("#start .will").getByText("measurements: a whole number from 1").waitFor();
    await page.fill("#measurements", "3");
    assert.equal(await start.isDisabled(), false);
    await press(page, "Record");
    await page.getByText("name: needed").waitFor();
    assert.deepEqual(server.requests, []);
});

test("A failing part of the page does not affect state, trip and ABORT", async () => {
    const { bench } = server;
    const { page, troubles } = await openPage(stage);
    bench.message = () => ({ ...Object.getPrototypeOf(bench).message.call(bench), losses: [{ stream: "camera:top" }] });
    await page.locator("#health-card").scrollIntoViewIfNeeded();
    await until(() => troubles.some((trouble) => /TypeError/.test(trouble)), "the table of losses fails");
    await page.keyboard.press("Escape");
    await isTripped(page);
    assert.match(await page.locator("#trip-text").textContent(), /^Tripped at [\d:]+: stopped by the operator\.$/);
    assert.equal(troubles.length, 1, "it is told once");
    delete bench.message;
});

test("Everything can be reached and read by keyboard and screen reader", async () => {
    const { page } = await openPage(stage);
    const unnamed = await page.evaluate(() => [...document.querySelectorAll("button, input, select, [tabindex]")]
        .filter((e) => !(e.labels?.length || e.getAttribute("aria-label") || e.getAttribute("aria-labelledby") || e.textContent.trim()))
        .map((e) => e.outerHTML));
    assert.deepEqual(unnamed, []);
    const wanted = await page.evaluate(() => [...document.querySelectorAll("button, input, select, summary, #log")]
        .filter((e) => !e.disabled && e.offsetParent !== null && e.id).map((e) => e.id));
    const reached = new Set();
    for (let k = 0; k < 60; k++) {
        await page.keyboard.press("Tab");
        reached.add(await page.evaluate(() => document.activeElement.id));
    }
    assert.deepEqual(wanted.filter((id) => !reached.has(id)), []);
    for (const [id, live] of [["state", "polite"], ["abort-status", "assertive"]])
        assert.equal(await page.locator(`#${id}`).getAttribute("aria-live"), live);
    for (const id of ["trip", "link", "hardware-stop"]) assert.equal(await page.locator(`#${id}`).getAttribute("role"), "alert");
});

/** Counts tones and notifications instead of playing and showing them. */
function spyOnAlarms() {
    globalThis.tones = 0;
    globalThis.shown = [];
    const start = OscillatorNode.prototype.start;
    OscillatorNode.prototype.start = function (...when) { globalThis.tones++; return start.apply(this, when); };
    globalThis.Notification = class {
        static permission = "granted";
        static requestPermission() { return Promise.resolve("granted"); }
        constructor(title, { body }) { globalThis.shown.push(`${title}: ${body}`); }
    };
}

test("The alarm is off by default; on, it sounds and notifies at a trip until it is acknowledged; the browser remembers it", { timeout: 60_000 }, async () => {
    const { bench } = server;
    await idle(stage);
    const { page, troubles } = await openPage(stage);
    await page.addInitScript(spyOnAlarms);
    await page.reload();
    const alarm = page.locator("#alarm"), silence = page.locator("#acknowledge");
    const tones = () => page.evaluate(() => globalThis.tones), shown = () => page.evaluate(() => globalThis.shown);
    await alarm.getByText("Alarm: off").waitFor();
    bench.act("abort");
    await page.locator("#clear-button").waitFor();
    await page.waitForTimeout(1500);
    assert.deepEqual([await tones(), await shown()], [0, []], "off: no sound, no notification");
    await press(page, "Clear the trip");
    await page.locator("#trip").waitFor({ state: "hidden" });
    await alarm.click();
    await alarm.getByText("Alarm: on").waitFor();
    assert.equal(await alarm.getAttribute("aria-pressed"), "true");
    bench.act("abort");
    await silence.waitFor();
    assert.deepEqual(await shown(), ["shakerd has tripped: stopped by the operator"]);
    await until(async () => (await tones()) >= 4, "it goes on");
    await silence.click();
    assert.equal(await silence.isVisible(), false);
    const heard = await tones();
    await page.waitForTimeout(1500);
    assert.equal(await tones(), heard, "silent");
    await press(page, "Clear the trip");
    await page.reload();
    await page.locator("#state").getByText("idle").waitFor();
    await alarm.getByText(/Alarm: (on|press once)/).waitFor();
    assert.deepEqual(troubles, []);
});

test("The pictures of a trip are shown with it; the simulated walker is put back, and only there", async () => {
    const { bench } = server;
    await idle(stage);
    const { page, troubles } = await openPage(stage);
    bench.x = 0.02;
    bench.act("abort");
    const figures = page.locator("#trip-pictures figure");
    await until(async () => await figures.count() === 2, "both pictures");
    await until(async () => /top, .* walker tracked/.test(await figures.first().textContent()), "the top picture");
    if (folder) await page.screenshot({ path: join(folder, "trip-pictures.png") });
    await press(page, "Clear the trip");
    await until(() => figures.first().isHidden(), "gone");
    await press(page, "Put the simulated walker back");
    await until(async () => bench.x === 0, "the walker is back");
    assert.deepEqual(troubles, []);
    const { message } = bench;
    bench.message = function () { const m = message.call(this); m.session.simulated = false; return m; };
    await page.locator("#reset-walker").waitFor({ state: "hidden" });
    delete bench.message;
});
