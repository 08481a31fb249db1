// The page with the real daemon on the simulated bench: actions of an operator in a real browser.
import assert from "node:assert/strict";
import { join } from "node:path";
import test, { after, before } from "node:test";
import { startDaemon } from "./daemon.mjs";
import { openBrowser, openPage } from "./stage.mjs";

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
    assert.deepEqual(troubles, []);
});
