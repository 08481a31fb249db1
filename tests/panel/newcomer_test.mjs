// A newcomer's first quarter of an hour at the page, with the real daemon on the simulated bench: no shell, no restart.
import assert from "node:assert/strict";
import { join } from "node:path";
import test, { after, before } from "node:test";
import { startDaemon } from "./daemon.mjs";
import { openBrowser, openPage, phone } from "./stage.mjs";

const folder = process.env.PANEL_SCREENSHOTS;
const wide = { width: 1440, height: 1000 };
let daemon, stage, page, troubles, steps = 0;

before(async () => {
    daemon = await startDaemon(0);
    stage = { server: { port: daemon.port }, browser: await openBrowser() };
    ({ page, troubles } = await openPage(stage, { hash: "", viewport: wide }));
});
after(async () => {
    await stage?.browser.close();
    await daemon?.end();
});

const press = (name) => page.getByRole("button", { name, exact: true }).click();
/** Waits until a text is as `pattern`. A failure tells the newest lines of the log. */
const becomes = async (id, pattern, patience = 120_000) => {
    try {
        await page.waitForFunction(({ id, source }) => new RegExp(source).test(document.getElementById(id).textContent), { id, source: pattern }, { timeout: patience });
    } catch (trouble) {
        const lines = await page.locator("#log li").allTextContents();
        throw new Error(`#${id} is "${await page.textContent(`#${id}`)}", not ${pattern}; log: ${lines.slice(0, 12).join(" | ")}; ${trouble.message}`);
    }
};
const stateIs = (word) => becomes("state", word);
const rowsAre = async (count) => {
    await page.locator("#results-card").scrollIntoViewIfNeeded();
    await page.waitForFunction((n) => document.querySelectorAll("#results-rows tr").length === n, count, { timeout: 20_000 });
};

/** Pictures of a step at both sizes. */
async function look(name) {
    if (!folder) return;
    const file = (size) => join(folder, `newcomer-${String(steps).padStart(2, "0")}-${name}-${size}.png`);
    steps++;
    await page.screenshot({ path: file("wide") });
    await page.screenshot({ path: file("whole"), fullPage: true });
    await page.setViewportSize(phone);
    await page.screenshot({ path: file("phone"), fullPage: true });
    await page.setViewportSize(wide);
}

const limits = { timeout: 300_000 };

test("Three measurements at the first set-point, then the drive stops by itself", limits, async () => {
    await stateIs("idle");
    await look("idle");
    await press("Take control");
    await press("Start");
    await stateIs("running");
    await look("running");
    await stateIs("idle");
    await rowsAre(3);
    assert.match(await page.textContent("#results"), /±/);
});

test("Another phase gives another drift", limits, async () => {
    await page.fill("#drive-phi", "180");  // it walks back
    await press("Set and arm");
    await stateIs("armed");
    await press("Start");
    await stateIs("running");
    await stateIs("idle");
    await rowsAre(6);
});

test("At the edge the drive stops; the walker comes back to the middle", limits, async () => {
    await page.selectOption("#how-long", "open");
    await press("Start");
    await stateIs("tripped");
    await becomes("trip-text", "edge");
    await look("tripped");
    await page.waitForFunction(() => !document.getElementById("clear-button").disabled);
    await press("Clear the trip");
    await stateIs("idle");
    await becomes("edge", "Bring it to the middle");
    await press("Bring the walker to the middle");
    await page.waitForFunction(() => document.getElementById("edge").hidden && /idle/.test(document.getElementById("state").textContent), null, { timeout: 60_000 });
    await look("middle");
});

test("A recording is found again and replays to the bit", limits, async () => {
    await page.fill("#record-name", "first");
    await press("Record");
    await becomes("record-button", "Do not record");
    await page.selectOption("#how-long", "count");
    await page.fill("#measurements", "1");
    await press("Start");
    await stateIs("running");
    await stateIs("idle");
    await page.locator("#recordings-card").scrollIntoViewIfNeeded();
    const row = page.locator("#recordings-rows tr", { hasText: "first.nxs" });
    await row.getByRole("button", { name: "Replay first.nxs" }).click({ timeout: 60_000 });
    await row.getByText("identical").waitFor({ timeout: 120_000 });
    await look("recorded");
});

test("A scan of phi runs by itself, and its report is opened from the page", limits, async () => {
    await page.fill("#scan-to", "180");
    await page.fill("#scan-steps", "2");
    await page.fill("#scan-periods", "20");
    await press("Measure the scan");
    await becomes("campaign-words", "^measuring");
    await look("scan");
    await becomes("campaign-words", "^ended: 3 of 3 points", 240_000);
    await look("scanned");
    const [report] = await Promise.all([page.context().waitForEvent("page"), page.getByRole("link", { name: "Open the report" }).click({ timeout: 120_000 })]);
    await report.waitForLoadState();
    assert.ok(await report.locator("svg, img").count() > 0, "the report of a scan has a figure");
    if (folder) await report.screenshot({ path: join(folder, "newcomer-report.png"), fullPage: true });
    assert.deepEqual(troubles, []);
});
