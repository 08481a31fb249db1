// The page in headless Chromium: whether it can be read, what its first screen shows, and that it stands still.
import assert from "node:assert/strict";
import { createRequire } from "node:module";
import { mkdirSync } from "node:fs";
import { join } from "node:path";
import test, { after, afterEach, before } from "node:test";
import { project } from "./sources.mjs";
import { idle, openPage, phone, pictured, running, setStage, still, until } from "./stage.mjs";

const axe = createRequire(join(project, "daemon/remote/panel/package.json")).resolve("axe-core/axe.min.js");
const folder = process.env.PANEL_SCREENSHOTS;
const wide = { width: 1440, height: 1000 };
const trip = {
    cause: "walker_edge", finding: "the walker is 4.97 mm from the edge of the picture (at least 5 mm)",
    advice: "clear the trip, then bring it back to the middle", value: 4.97, limit: 5, recording: "tail.nxs",
};
let stage;
before(async () => {
    stage = await setStage();
    const { bench } = stage.server;
    for (const v of [6.5994e-3, 6.6004e-3]) bench.measure(v);
    bench.recordings = [{ name: "series.nxs", bytes: 3_210_000, changed: "2026-01-02T03:04:05Z", started: "2026-01-02T03:00:00Z", outcome: "complete", trouble: null,
        set_points: [{ frequency_hz: 20, gamma_mps2: 9.8, rho: 0.5, phi_rad: 1.75 }], remarks: ["new paper"], replay: null, replay_text: null }];
});
after(() => stage.clear());
afterEach(() => stage.closePages());

const states = {
    idle: () => idle(stage),
    running: () => running(stage),
    tripped: async () => {
        const { bench } = stage.server;
        await running(stage);
        bench.trip = { ...trip, t_s: bench.time };
        bench.become("tripped");
    },
};

const sizes = { wide, phone };
const primaries = (page) => page.locator("button.primary").evaluateAll((all) => all.filter((e) => e.offsetParent !== null || e.getClientRects().length).map((e) => e.id));
const next = { idle: "start-button", running: "stop-button", tripped: "clear-button" };

for (const [name, reach] of Object.entries(states))
    test(`${name}: no rule of accessibility is broken, one order stands out, and nothing is wider than the screen`, { timeout: 120_000 }, async () => {
        await running(stage);  // so that there is a result and a track
        const { page, troubles } = await openPage(stage, { viewport: wide, bypassCSP: true });
        await page.addScriptTag({ path: axe });
        await page.waitForTimeout(800);
        await reach();
        await until(async () => (await primaries(page)).join() === next[name], "the order that stands out");
        for (const [size, viewport] of Object.entries(sizes)) {
            await page.setViewportSize(viewport);
            for (const colorScheme of ["light", "dark"]) {
                await page.emulateMedia({ colorScheme });
                await page.waitForTimeout(300);
                if (folder) await keep(page, viewport, `${name}-${colorScheme}-${size}`);
                const { violations } = await page.evaluate(() => globalThis.axe.run({ resultTypes: ["violations"] }));
                assert.deepEqual(violations.map(({ id, help, nodes }) => `${size} ${colorScheme} ${id}: ${help}: ${nodes.slice(0, 4).map((n) => `${n.html.slice(0, 120)} ${n.any[0]?.message ?? ""}`).join(" | ")}`), []);
            }
            assert.equal(await page.evaluate(() => document.documentElement.scrollWidth - innerWidth), 0);
            const wider = await page.evaluate(() => [...document.querySelectorAll(".card *")].filter((e) => !e.closest(".scroll, .plot, .log, svg") &&
                e.getBoundingClientRect().right > e.closest(".card").getBoundingClientRect().right + 0.5).map((e) => e.id || e.outerHTML.slice(0, 80)));
            assert.deepEqual(wider, [], `${size}: within its card`);
        }
        assert.deepEqual(troubles, []);
    });

test("The first screen has the drive, the result, the state, the orders and the live pictures", async () => {
    await running(stage);
    const { page } = await openPage(stage, { viewport: wide });
    await until(async () => (await page.textContent("#v-D")) !== "–", "a result");
    const seen = ["state", "abort", "start-button", "stop-button", "drive-set", "gamma", "gamma-asked", "v-D", "D", "waveform", "walker-track", "record-button"];
    for (const id of seen) {
        const box = await page.locator(`#${id}`).boundingBox();
        assert.ok(box && box.y >= 0 && box.y + box.height <= wide.height, `#${id} ${JSON.stringify(box)}`);
    }
    await until(async () => {
        const boxes = await Promise.all((await page.locator("#cameras canvas").all()).map((canvas) => canvas.boundingBox()));
        return boxes.length === 2 && boxes.every((box) => box.width > 300 && box.y + box.height <= wide.height);
    }, "both pictures");
    await until(async () => /walker tracked/.test(await page.textContent("#cameras")), "a picture");
});

test("From rest to a trip nothing moves under the pointer", async () => {
    const { bench } = stage.server;
    await idle(stage);
    const { page } = await openPage(stage, { viewport: wide });
    await pictured(page);
    const places = () => page.locator("header button, .controls button, .controls input, .controls select, main > section").evaluateAll((all) => Object.fromEntries(all
        .map((e, i) => [`${i} ${e.id || e.getAttribute("aria-labelledby") || e.textContent}`, e.getBoundingClientRect()]).filter(([, r]) => r.width && r.y < innerHeight).map(([name, r]) => [name.replace(/Take control|Release control/, "control"), [r.x, r.y].map(Math.round).join()])));
    const first = await still(places, "the page");
    assert.ok(Object.keys(first).length > 20);
    bench.record_next = true;
    bench.record_name = "a name";
    bench.become("armed");
    await page.waitForTimeout(500);
    assert.deepEqual(await places(), first, "armed");
    await running(stage);
    await page.waitForTimeout(500);
    assert.deepEqual(await places(), first, "running");
    await states.tripped();
    await until(() => page.locator("#clear-button").isVisible(), "the trip");
    await page.waitForTimeout(500);
    assert.deepEqual(await places(), first, "tripped");
    bench.x = 0.0295;
    bench.edge = 0.015;
    await idle(stage);
    await until(() => page.locator("#edge").isVisible(), "the edge");
    assert.deepEqual(await places(), first, "at the edge");
    bench.edge = 0.005;
    bench.x = 0;
});

test("An answer to an order moves no button, and a refusal below one lets presses through", { timeout: 120_000 }, async () => {
    const { server } = stage, refused = "the walker is 4.97 mm from the edge of the picture (at least 5 mm): bring it to the middle, then start again";
    for (const [name, viewport] of Object.entries(sizes))
        for (const at of ["idle", "tripped"]) {
            await states[at]();
            const { page } = await openPage(stage, { viewport });
            await pictured(page);
            const places = () => page.locator("button").evaluateAll((all) => all.filter((e) => e.getClientRects().length)
                .map((e) => { const r = e.getBoundingClientRect(); return [e.id || e.textContent, r.x + scrollX, r.y + scrollY, r.width].join(); }));
            const shown = at === "idle" ? "form[data-action]:not(.banner *)" : ".banner form";
            const ids = await page.locator(shown).evaluateAll((all) => all.filter((e) => e.getClientRects().length && e.querySelector("output")).map((e) => e.dataset.action));
            assert.ok(ids.length > (at === "idle" ? 9 : 0), ids.join());
            const first = await still(places, "the page");
            server.refuse = refused;
            for (const id of ids) {
                const form = page.locator(`form[data-action="${id}"]`).filter({ visible: true }).first(), answer = form.locator("output");
                await form.evaluate((e) => e.requestSubmit());
                await until(async () => await answer.getAttribute("data-kind") === "error", `refused: ${id}`);
                assert.deepEqual(await places(), first, `${name} ${at}: ${id} was refused`);
                const box = await answer.evaluate((e) => { const r = e.getBoundingClientRect(), b = e.closest("form").querySelector("button").getBoundingClientRect(); return [r.width, r.height, r.y - b.y, r.right - innerWidth, r.bottom - innerHeight]; });
                assert.ok(box[0] > 150 && box[1] > 15 && box[2] > 20 && box[3] <= 0 && (at === "idle" || box[4] <= 0), `${name} ${id}: ${box}`);
            }
            assert.equal(await page.evaluate(() => document.documentElement.scrollWidth - innerWidth), 0);
            if (folder) await page.screenshot({ path: join(folder, `refused-${at}-${name}.png`) });
            await page.locator("h1, #state").last().click();
            await until(async () => (await page.locator(".answer[data-kind=error]:not([hidden])").count()) === 0, "gone at the next press");
            server.refuse = null;
            if (at !== "idle") continue;
            await page.locator("#start-button").scrollIntoViewIfNeeded();
            server.refuse = refused;
            await page.click("#start-button");
            await page.locator("#start output").getByText("the walker is").waitFor();
            const sent = server.requests.length;
            await page.click("#stop-button");
            await until(() => server.requests.slice(sent).some((request) => request.name === "stop"), "the press on Stop below the refusal");
            server.refuse = null;
        }
});

test("At rest the measured motion has no figures", async () => {
    await idle(stage);
    const { page } = await openPage(stage, { viewport: wide });
    for (const id of ["gamma", "phi", "rms", "volts"]) assert.equal(await page.textContent(`#${id}`), "–");
    await page.locator("#harmonics-card").scrollIntoViewIfNeeded();
    await until(async () => await page.locator("#harmonics-rows tr").count() === 8, "harmonics");
    for (const cell of await page.locator("#harmonics-rows td:nth-child(3)").allTextContents()) assert.equal(cell, "–");
});

async function keep(page, viewport, name) {
    mkdirSync(folder, { recursive: true });
    await page.screenshot({ path: join(folder, `${name}.png`) });
    await page.setViewportSize({ width: viewport.width, height: await page.evaluate(() => document.documentElement.scrollHeight) });
    await page.waitForTimeout(800);
    await page.screenshot({ path: join(folder, `${name}-whole.png`) });
    await page.setViewportSize(viewport);
}
