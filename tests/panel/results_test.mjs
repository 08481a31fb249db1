// The page in headless Chromium: the table of results and the list of recordings.
import assert from "node:assert/strict";
import { readFile } from "node:fs/promises";
import { join } from "node:path";
import test, { after, afterEach, before } from "node:test";
import { idle, openPage, phone, setStage, still, until } from "./stage.mjs";

const folder = process.env.PANEL_SCREENSHOTS;
let stage;
before(async () => { stage = await setStage(); });
after(() => stage.clear());
afterEach(() => stage.closePages());

const rows = (page) => page.locator("#results-rows tr");
const cells = (page, row) => rows(page).nth(row).locator("th, td").allTextContents();

test("Results are a row a measurement, the newest first; repeats are averaged", async () => {
    const { bench } = stage.server;
    await idle(stage);
    const { page, troubles } = await openPage(stage, { viewport: { width: 1440, height: 1000 } });
    assert.equal(await page.textContent("#results-count"), "No measurement yet.");
    bench.measure(6.5994e-3);
    bench.measure(6.6004e-3);
    bench.act("control/request");
    bench.act("drive", { phi_rad: 1.75 });
    bench.measure(null, { v_D_mps: null, D_m: null, efficiency: null, gamma_mps2: null, rho: null, phi_rad: null, steady: false, ended: "walker 4.9 mm from the edge", recording: null });
    await until(async () => await rows(page).count() === 3, "three rows");
    const [time, setPoint, v, D, , gamma, , , steady, ended, recording] = await cells(page, 1);
    assert.match(time, /^\d\d:\d\d:\d\d$/);
    assert.deepEqual([setPoint, v, D, gamma, steady, ended, recording],
        ["γ 1 g, φ 0°, ρ 0.5, 20 Hz", "6.6004 ± 0.0010", "0.330020 ± 0.000050", "1.00030 ± 0.00010", "✓ steady", "complete", "series.nxs"]);
    assert.deepEqual((await cells(page, 0)).slice(2), ["–", "–", "–", "–", "–", "–", "", "walker 4.9 mm from the edge", "not recorded"]);
    if (folder) await page.screenshot({ path: join(folder, "results.png"), fullPage: true });
    bench.repeats = [{
        asked: { gamma_mps2: 9.8, phi_rad: 0, rho: 0.5, frequency_hz: 20 }, newest: bench.rows[0].time, count: 2, v_D_mps: { value: 6.5999e-3, sigma: 7.1e-7 },
        D_m: { value: 3.3e-4, sigma: 4e-8 }, efficiency: null, stated_mps: 1e-6, scatter_mps: 7.1e-7,
    }];
    await page.check("#results-averaged");
    await until(async () => await rows(page).count() === 1, "one set-point");
    assert.deepEqual((await cells(page, 0)).slice(1, 6), ["γ 1 g, φ 0°, ρ 0.5, 20 Hz", "2", "6.59990 ± 0.00071", "0.00071", "0.00100"]);
    if (folder) await page.locator("#results-card").screenshot({ path: join(folder, "results-averaged.png") });
    assert.deepEqual(troubles, []);
});

test("A click on a row takes its set-point into the form, unsent", async () => {
    const { page } = await openPage(stage);
    stage.server.bench.act("drive", { phi_rad: 0, gamma_mps2: 4.9 });
    await until(async () => await page.inputValue("#drive-gamma") === "0.5", "the present drive");
    const sent = stage.server.requests.length;
    await page.locator("#results-card").scrollIntoViewIfNeeded();  // it is drawn in view
    await rows(page).nth(0).locator("td").nth(9).click();
    assert.deepEqual([await page.inputValue("#drive-gamma"), await page.inputValue("#drive-phi")], ["1", "100.267614"]);
    assert.ok(await page.locator("#drive-phi").evaluate((e) => e.classList.contains("edited")));
    assert.equal(stage.server.requests.length, sent);
});

test("A click on a point of a plot takes its set-point; the plot is saved as a picture and as numbers", async () => {
    const { bench } = stage.server;
    bench.points = [];
    const { page, troubles } = await openPage(stage, { viewport: { width: 1440, height: 1000 } });
    await page.locator("#phi-card").scrollIntoViewIfNeeded();
    await until(async () => await page.locator("#points-phi .u-over").count() === 1, "the plot");
    await still(() => page.locator("#points-phi canvas").screenshot(), "the plot", 700);
    const area = await page.locator("#points-phi .u-over").boundingBox();
    // Two repeats at phi 0 in the middle of an axis of 90 degrees, v_D 6.6 mm/s near the upper end.
    const top = area.height * (1 - (6.6 + 0.07 * 6.6) / (1.14 * 6.6));
    await page.fill("#drive-phi", "33");
    await page.locator("#points-phi .u-over").click({ position: { x: area.width / 2, y: top } });
    assert.equal(await page.inputValue("#drive-phi"), "0");
    const save = async (kind) => {
        const saved = page.waitForEvent("download");
        await page.locator(`#phi-card button[data-save=${kind}]`).click();
        return readFile(await (await saved).path());
    };
    const csv = (await save("CSV")).toString().trim().split("\r\n");
    assert.equal(csv.length, 3);
    assert.match(csv[1], /^"others",0(\.0+)?,6\.5994/);
    assert.equal((await save("PNG")).subarray(1, 4).toString(), "PNG");
    if (folder) await page.locator("#phi-card").screenshot({ path: join(folder, "phi.png") });
    assert.deepEqual(troubles, []);
});

test("From the first point on, a plot has the exact law and the closed form with the band of mu's error", async () => {
    const { bench } = stage.server;
    bench.points = [];
    bench.act("drive", { gamma_mps2: 9.8, phi_rad: 0, rho: 0.5, frequency_hz: 20 });
    const { page, troubles } = await openPage(stage, { viewport: { width: 1440, height: 1000 } });
    for (const [axis, other] of [["gamma", /exact law, φ = 0°, μ = 0.1130 ± 0.0050/], ["phi", /exact law, γ = 1.00 g, μ = 0.1130 ± 0.0050/]]) {
        bench.law_mu = null;
        await page.locator(`#${axis}-card`).scrollIntoViewIfNeeded();
        const canvas = page.locator(`#points-${axis} canvas`), key = page.locator(`#key-${axis}`);
        await until(async () => !/law|closed/.test(await key.textContent()), "no law without mu");
        const before = await still(() => canvas.screenshot(), "the plot", 1200);
        bench.law_mu = { value: 0.113, sigma: 0.005 };
        bench.act("drive", { frequency_hz: 20.5 });  // a new set-point is a new law
        await until(async () => other.test(await key.textContent()), `the law in the key: ${await key.textContent()}`);
        assert.match(await key.textContent(), /closed form/);
        await until(async () => !before.equals(await canvas.screenshot()), "the law is drawn");
        if (folder) await page.locator(`#${axis}-card`).screenshot({ path: join(folder, `law-${axis}.png`) });
        const saved = page.waitForEvent("download");
        await page.locator(`#${axis}-card button[data-save=CSV]`).click();
        const csv = (await readFile(await (await saved).path())).toString().trim().split("\r\n"), law = csv.filter((row) => row.startsWith('"law at'));
        assert.ok(law.length > 20, csv.join("|"));
        const [v, low, high] = law.at(-1).split(",").slice(-3).map(Number);
        assert.ok(low <= v && v <= high && low < high, law.at(-1));
        bench.law_mu = null;
        bench.act("drive", { frequency_hz: 20 });
    }
    assert.deepEqual(troubles, []);
});

test("The CSV is saved with the token; the table scrolls inside its card on a phone", async () => {
    const { page } = await openPage(stage, { viewport: phone });
    await page.locator("#results-card").scrollIntoViewIfNeeded();
    await until(async () => await rows(page).count() === 3, "the rows of before");
    const saved = page.waitForEvent("download");
    await page.click("#results-csv");
    assert.equal(await readFile(await (await saved).path(), "utf8"), "opensesame,3");
    assert.equal(await page.evaluate(() => document.documentElement.scrollWidth - innerWidth), 0);
    if (folder) await page.locator("#results-card").screenshot({ path: join(folder, "results-phone.png") });
});

test("Recordings are listed with their outcome, can be saved, and are checked on request", async () => {
    const { bench } = stage.server;
    const asked = { frequency_hz: 20, gamma_mps2: 9.8, rho: 0.5, phi_rad: 0, overtones: [] };
    const recording = { bytes: 5.2e6, changed: "2026-11-25T10:00:00Z", started: "2026-11-25T09:59:00Z", outcome: "2 measurements", trouble: null, remarks: ["new paper"], replay: null, replay_text: null };
    bench.recordings = [{ ...recording, name: "series.nxs", set_points: [asked, { ...asked, phi_rad: 1 }] },
        { ...recording, name: "broken.nxs", outcome: null, started: null, set_points: [], remarks: [], trouble: "not an HDF5 file" }];
    bench.campaigns = [{ name: "scan-1", bytes: 2e7, changed: "2026-11-25T11:00:00Z", recordings: 3, complete: true, report: null, report_text: null }];
    const { page, troubles } = await openPage(stage, { viewport: { width: 1440, height: 1000 } });
    const line = (row) => page.locator("#recordings-rows tr").nth(row).locator("th, td").allTextContents();
    await page.locator("#recordings-card").scrollIntoViewIfNeeded();
    await until(async () => await page.locator("#recordings-rows tr").count() === 2, "two recordings");
    const [name, time, ...rest] = await line(0);
    assert.equal(name, "series.nxs");
    assert.match(time, /^2[456] Nov \d\d:\d\d$/);
    assert.deepEqual(rest, ["5.20 MB", "γ 1 g, φ 0°, ρ 0.5, 20 Hz and 1 more", "2 measurements", "new paper", "replay"]);
    assert.deepEqual((await line(1)).slice(3), ["", "⚠ not readable: not an HDF5 file", "", ""]);
    assert.equal(await page.getByRole("link", { name: "series.nxs" }).getAttribute("href"), "api/recordings/series.nxs?token=opensesame");
    bench.control = true;
    await page.getByRole("button", { name: "Replay series.nxs" }).click();
    await until(async () => (await line(0))[6] === "✓ identical again", "its verdict");
    const campaign = () => page.locator("#campaigns-rows tr").locator("th, td").allTextContents();
    const [folderName, , ...of] = await campaign();
    assert.equal(folderName, "scan-1");
    assert.deepEqual(of, ["20.0 MB", "campaign of 3 recordings", "points table written", "", "make the report"]);
    await page.getByRole("button", { name: "Make the report of scan-1" }).click();
    await until(async () => (await campaign())[6] === "report again", "the report");
    assert.equal(await page.getByRole("link", { name: "Report of scan-1" }).getAttribute("href"), "api/campaigns/scan-1/report?token=opensesame");
    assert.equal(await page.inputValue("#record-frames"), "first-second");
    assert.equal(await page.textContent("#record-room"), "The disk has room for 61 h 38 min of recording.");
    await page.selectOption("#record-frames", "region");
    await until(async () => await page.textContent("#record-room") === "The disk has room for 37 min 45 s of recording.", "that of all pictures");
    await page.selectOption("#record-frames", "first-second");
    if (folder) await page.locator("#recordings-card").screenshot({ path: join(folder, "recordings.png") });
    assert.deepEqual(troubles, []);
});
