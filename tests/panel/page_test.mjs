// The page in headless Chromium: its display.
import assert from "node:assert/strict";
import { mkdirSync } from "node:fs";
import { join } from "node:path";
import test, { after, afterEach, before } from "node:test";
import { idle, laptop, openPage, phone, running, setStage, still, until } from "./stage.mjs";

const folder = process.env.PANEL_SCREENSHOTS;
let stage;
before(async () => { stage = await setStage(); });
after(() => stage.clear());
afterEach(() => stage.closePages());

const text = (page, id) => page.locator(`#${id}`).textContent();
const overflow = (page) => page.evaluate(() => document.documentElement.scrollWidth - innerWidth);

test("The page loads without console errors, policy violations and requests to other hosts", async () => {
    const { page, troubles } = await openPage(stage);
    await page.waitForTimeout(1500);
    for (const card of await page.locator(".card").all()) await card.scrollIntoViewIfNeeded();
    await page.waitForTimeout(500);
    assert.deepEqual(troubles, []);
    assert.equal(await page.evaluate(() => location.hash), "");
});

test("The page shows results with errors, drive and state", async () => {
    await running(stage);
    const { page } = await openPage(stage);
    await until(async () => (await text(page, "v-D")) !== "–", "v_D");
    const [value, sigma] = (await text(page, "v-D")).split(" ± ").map(Number);
    assert.ok(Math.abs(value - 14.584) < 0.001 + 5 * sigma && sigma > 0, `${value} ${sigma}`);
    for (const id of ["D", "efficiency", "mu"]) assert.match(await text(page, id), /^[\d.]+ ± [\d.]+$/);
    assert.match(await text(page, "ratio"), /^-?[\d.]+ ± [\d.]+ %$/);
    assert.equal(await text(page, "gamma-asked"), "1.000 g (9.800 m/s²)");
    assert.match(await text(page, "steady"), /✓ steady, \d+ periods/);
    assert.match(await text(page, "state"), /running/);
    await page.locator("#log").scrollIntoViewIfNeeded();
    await until(async () => /running/.test(await text(page, "log")), "the log");
});

test("A result of another set-point is grey and shows its measurement", async () => {
    const { bench } = stage.server;
    await running(stage);
    const { page } = await openPage(stage);
    const grey = () => page.locator("#v-D").evaluate((e) => getComputedStyle(e).filter);
    await until(async () => /^Measurement \d+ at .*: γ 1\.000 g .* φ 0\.00°/.test(await text(page, "result-of")), "its origin");
    assert.match(await text(page, "result-of"), /; never sticks for over 0\.031 T$/);
    assert.equal(await grey(), "none");
    bench.unfinished = true;
    bench.act("drive", { phi_rad: 2 });
    await until(async () => (await text(page, "result-of")).startsWith("⚠ The set-point has changed"), "old");
    assert.match(await text(page, "result-of"), /φ 0\.00°/);
    assert.match(await text(page, "phi-asked"), /114\.59°/);
    assert.equal(await grey(), "grayscale(1)");
    bench.unfinished = false;
    await until(async () => /^Measurement .* φ 114\.59°/.test(await text(page, "result-of")), "measured again");
    assert.equal(await grey(), "none");
    bench.act("drive", { phi_rad: 0 });
});

test("A mu of a law that the measurements refuse is no number; the reason stands below", async () => {
    const { bench } = stage.server;
    await running(stage);
    const { page } = await openPage(stage);
    await until(async () => /^0\.1\d+ ± /.test(await text(page, "mu")), "mu");
    bench.mu_refused = "chi^2 is 25 times its degrees of freedom";
    await until(async () => (await text(page, "mu")) === "–", "no mu");
    assert.match(await text(page, "result-of"), /; no single μ: chi\^2 is 25 times its degrees of freedom$/);
    bench.mu_refused = "";
    await until(async () => /^0\.1\d+ ± /.test(await text(page, "mu")), "mu again");
});

test("The walker's mark agrees with the picture", async () => {
    const { bench } = stage.server;
    await idle(stage);
    const { page } = await openPage(stage);
    const mark = () => page.locator("#walker-mark").evaluate((e) => Number.parseFloat(e.style.left));
    for (const [x, share] of [[-0.03, 20], [0.02, 70]]) {
        bench.x = x;
        await until(async () => Math.abs((await mark()) - share) < 0.1, `the mark at ${share} %`);
        assert.deepEqual([await text(page, "walker-low"), await text(page, "walker-high")], ["0.0 mm", "100.0 mm"]);
    }
    bench.mirrored = true;  // x grows to the left in this picture
    await until(async () => Math.abs((await mark()) - 30) < 0.1, "the mark in the mirrored picture");
    assert.deepEqual([await text(page, "walker-low"), await text(page, "walker-high")], ["100.0 mm", "0.0 mm"]);
    bench.mirrored = false;
});

test("A walker at the edge is brought back from the page", async () => {
    const { bench } = stage.server;
    await idle(stage);
    const { page } = await openPage(stage);
    const primary = (id) => page.locator(`#${id}`).evaluate((e) => e.classList.contains("primary"));
    bench.x = 0.01;
    await until(async () => /^walker at 60\.0 mm, 34\.0 mm from the edge \(limit 5\.0 mm\)$/.test(await text(page, "walker-at")), "its place");
    assert.equal(await page.locator("#edge").isVisible(), false);
    assert.deepEqual([await primary("start-button"), await primary("middle-button")], [true, false]);
    bench.edge = 0.015;
    bench.x = 0.0295;
    await until(async () => (await text(page, "edge")) === "The walker is 14.5 mm from the edge of the picture (limit 15.0 mm). Bring it to the middle before the next run.", "the way out");
    assert.deepEqual([await primary("start-button"), await primary("middle-button")], [false, true]);
    await page.click("#middle-button");
    await until(async () => (await text(page, "state")) === "↔ to the middle", "its state");
    await until(async () => (await text(page, "state")) === "○ idle", "it is there");
    assert.equal(bench.x, 0);
    bench.edge = 0.005;
    assert.equal(await page.locator("#edge").isVisible(), false);
});

test("Before the start the page says how long it takes, how far the walker goes and how many bytes", async () => {
    const { bench } = stage.server;
    await idle(stage);
    bench.drive = { ...bench.drive, phi_rad: 0 };
    bench.x = 0;
    const { page } = await openPage(stage);
    await page.fill("#periods", "20");
    await until(async () => /^About 6\.0 s, of which 3\.0 s are measured\. ⚠ It does not fit: the walker reaches the edge limit, 30\.0 mm away, after about 21 of 60 periods\.$/.test(await text(page, "outlook")), "it does not fit");
    await page.fill("#measurements", "1");
    await page.fill("#periods", "5");
    await until(async () => /The walker goes about 18\.2 mm; the edge limit is 30\.0 mm away\.$/.test(await text(page, "outlook")), "it fits");
    bench.record_next = true;
    await until(async () => /Recorded: about 51.6 MB\.$/.test(await text(page, "outlook")), "its bytes");
    await page.selectOption("#how-long", "open");
    await until(async () => /^First result after about 3\.3 s, then on until stopped\. The walker reaches/.test(await text(page, "outlook")), "until stopped");
    assert.ok(await page.locator("#measurements").isDisabled());
    bench.record_next = false;
});

test("A run shows its step, its progress, the way to the edge and the gauges", async () => {
    const { bench } = stage.server;
    await running(stage);
    bench.asked = 3;
    const { page } = await openPage(stage);
    await until(async () => /^measurement \d+ of 3: \d+ of \d+ periods; about 3\.2 s left; 38 periods to the edge limit$/.test(await text(page, "progress")), "its progress");
    assert.equal(await page.locator("#progress").getAttribute("data-kind"), "trouble");  // 3.2 s are 64 periods
    assert.deepEqual(await page.locator("#steps li").evaluateAll((all) => all.map((e) => e.dataset.kind)), ["past", "past", "past", "past", "now"]);
    assert.match(await text(page, "gauges"), /acceleration8\.62 of 60\.0 m\/s².*drive0\.412 of 1\.00 V/);
    assert.equal(await page.locator("#gauges i").first().evaluate((e) => Math.round(parseFloat(e.style.width))), 14);
    await idle(stage);
    await until(async () => (await text(page, "progress")) === "", "at rest");
    assert.equal(await text(page, "steady"), "");
    bench.asked = 0;
});

test("Friction is given from the page, and nonsense is not sent", async () => {
    const { bench } = stage.server;
    await idle(stage);
    const { page } = await openPage(stage);
    await page.fill("#mu-value", "little");
    await page.press("#mu-value", "Enter");
    await until(async () => /friction: "little" is not a number/.test(await text(page, "give-mu")), "the reason");
    await page.fill("#mu-value", "-1");
    await page.press("#mu-value", "Enter");
    await until(async () => /mu "-1": out of range/.test(await text(page, "give-mu")), "the refusal");
    assert.equal(bench.given_mu, null);
    await page.fill("#mu-value", "0.12");
    await page.press("#mu-value", "Enter");
    await until(() => bench.given_mu === 0.12, "mu");
});

test("A trip has its time, its sentence, its recording and the last two seconds with the limit", async () => {
    const { bench } = stage.server;
    await running(stage);
    const { page } = await openPage(stage);
    await page.waitForTimeout(1500);
    bench.trip = {
        cause: "walker_edge", finding: "the walker is 4.97 mm from the edge of the picture (at least 5 mm)",
        advice: "clear the trip, then bring it back to the middle", value: 4.97, limit: 5, t_s: bench.time, recording: "tail.nxs",
    };
    bench.become("tripped");
    await until(async () => /^Tripped at \d\d:\d\d:\d\d: the walker is 4\.97 mm from the edge of the picture \(at least 5 mm\)\. Clear the trip, then bring it back to the middle\. Recorded in tail\.nxs\.$/
        .test(await text(page, "trip-text")), "its sentence");
    await until(() => page.locator("#trip-plot canvas").isVisible(), "its curve");
    bench.act("clear");
    await until(async () => !(await page.locator("#trip").isVisible()), "cleared");
});

test("Refused real time is shown with its reason", async () => {
    const { page } = await openPage(stage);
    await page.locator("#real-time").scrollIntoViewIfNeeded();  // a card that is not seen is not drawn
    await until(async () => (await text(page, "real-time")) === "⚠ refused: memory", "the refusal");
    assert.equal(await text(page, "abort-contact"), "⚠ open");
    assert.equal(await text(page, "enable-output"), "off");
    assert.match(await page.locator("#real-time").getAttribute("title"), /8192 kB/);
});

test("Every plot and both cameras move with the data", async () => {
    await running(stage);
    const { page } = await openPage(stage);
    for (const id of ["waveform", "harmonics", "cycle-x", "cycle-v", "friction", "live-track", "live-acceleration", "jitter", "cameras"]) {
        const canvas = page.locator(`#${id} canvas`).first();
        await page.locator(`#${id}`).scrollIntoViewIfNeeded();  // it is drawn in view
        await until(async () => (await canvas.boundingBox())?.width > 100, id);
        await page.waitForTimeout(700);
        const before = await canvas.screenshot();
        await until(async () => !before.equals(await canvas.screenshot()), `${id} moves`);
    }
});

test("A new point appears in the plots of the points", async () => {
    await running(stage);
    const { page } = await openPage(stage);
    const canvas = page.locator("#points-gamma canvas");
    await page.locator("#gamma-card").scrollIntoViewIfNeeded();  // it is drawn in view
    await canvas.scrollIntoViewIfNeeded();
    const before = await still(() => canvas.screenshot(), "the plot without a new point", 1200);
    stage.server.bench.points.push({ gamma_mps2: 14.7, phi_rad: 0, v_D_mps: -0.02, sigma_mps: 1e-3, closed_form_mps: null });
    await until(async () => !before.equals(await canvas.screenshot()), "the point is drawn");
});

for (const [name, viewport, scale] of [["laptop", laptop, 1], ["phone", phone, 2]])
    for (const colorScheme of ["light", "dark"])
        test(`On a ${name} in ${colorScheme} colours nothing is wider than the screen`, async () => {
            await running(stage);
            const { page, troubles } = await openPage(stage, { viewport, colorScheme, deviceScaleFactor: scale });
            await page.waitForTimeout(1500);
            assert.equal(await overflow(page), 0);
            const cut = await page.evaluate(() => [...document.querySelectorAll("dd, p, td, th, button, label")]
                .filter((e) => e.scrollWidth > e.clientWidth + 1 && getComputedStyle(e).display !== "inline" && !e.hidden)
                .map((e) => `${e.tagName}#${e.id} ${e.textContent}`));
            assert.deepEqual(cut, []);
            if (folder) await keepPicture(page, viewport, `${name}-${colorScheme}`);
            assert.deepEqual(troubles, []);
        });

async function keepPicture(page, viewport, name) {
    mkdirSync(folder, { recursive: true });
    await page.screenshot({ path: join(folder, `${name}.png`) });
    const height = await page.evaluate(() => document.documentElement.scrollHeight);
    await page.setViewportSize({ width: viewport.width, height });
    await page.waitForTimeout(2000);
    await page.screenshot({ path: join(folder, `${name}-whole.png`) });
}

test("Texts of any length fit on a phone", async () => {
    const { bench } = stage.server;
    await running(stage);
    const { page } = await openPage(stage, { viewport: phone });
    bench.recording = "walker_on_glass_".repeat(7);
    bench.trip = { cause: "acceleration", finding: "x".repeat(300), advice: "y".repeat(300), t_s: 123456.7 };
    bench.log("warning", "/a/very/long/path".repeat(20));
    await until(async () => (await text(page, "trip-text")).includes("xxx"), "the trip is told");
    await page.locator("#log").scrollIntoViewIfNeeded();
    await until(async () => /very\/long/.test(await text(page, "log")), "the event is told");
    assert.equal(await overflow(page), 0);
    bench.recording = bench.trip = null;
});

test("A picture has its figures, and a lost target stays where it was, with the time since", async () => {
    const { bench } = stage.server;
    await idle(stage);
    bench.x = 0;
    const { page } = await openPage(stage, { viewport: { width: 1440, height: 1000 } });
    const caption = () => page.locator("#cameras figcaption").first().textContent();
    await until(async () => /^top, [\d.]+ s: base tracked, walker tracked; exposed for 0\.20 ms, 0\.20 % clipped, edges 2\.4 px$/.test(await caption()), "its words");
    // Orange pixels of a row through the middle of the walker: 64 px of 640 wide, it is in the middle.
    const orange = () => page.locator("#cameras canvas").first().evaluate((canvas) => {
        const { data } = canvas.getContext("2d").getImageData(0, Math.round(canvas.height / 2), canvas.width, 1);
        const found = [...Array(canvas.width).keys()].filter((x) => data[4 * x] > 200 && data[4 * x + 1] > 120 && data[4 * x + 1] < 190 && data[4 * x + 2] < 60);
        return found.map((x) => Math.round((100 * x) / canvas.width));
    });
    const place = await orange();
    assert.ok(place.length > 1 && Math.abs((place[0] + place.at(-1)) / 2 - 50) < 3, place.join());
    bench.walker_lost = true;
    await until(async () => /walker lost/.test(await caption()), "it is lost");
    await page.waitForTimeout(300);
    const upper = await page.locator("#cameras canvas").first().screenshot();
    await until(async () => !upper.equals(await page.locator("#cameras canvas").first().screenshot()), "the time since goes on");
    bench.walker_lost = false;
    await until(async () => /walker tracked/.test(await caption()), "found again");
});

test("A repeated event is one line with its count", async () => {
    const { bench } = stage.server;
    const { page } = await openPage(stage);
    await page.locator("#log").scrollIntoViewIfNeeded();
    bench.log("order", "abort by a flood");
    await until(async () => /a flood$/.test(await page.locator("#log li").first().textContent()), "the event is told");
    const lines = await page.locator("#log li").count();
    const { id } = bench.events.at(-1);
    for (const more of [1, 2, 4]) bench.tell({ type: "event", id, t_s: 1, kind: "order", text: `abort by a flood (${more} more)` });
    await until(async () => /4 more/.test(await page.locator("#log li").first().textContent()), "the count is told");
    assert.equal(await page.locator("#log li").count(), lines);
});

test("The theme's button changes the colours of page and plots, and a reload keeps them", async () => {
    const { page } = await openPage(stage, { colorScheme: "light" });
    const ground = () => page.evaluate(() => getComputedStyle(document.body).backgroundColor);
    const light = await ground();
    await page.click("#theme");
    await page.click("#theme");
    assert.match(await text(page, "theme"), /dark/);
    const dark = await ground();
    assert.notEqual(dark, light);
    await page.reload();
    assert.equal(await ground(), dark);
});

test("The contrast of text is at least 4.5 to 1 in both themes", async () => {
    for (const colorScheme of ["light", "dark"]) {
        const { page } = await openPage(stage, { colorScheme });
        const ratios = await page.evaluate(() => {
            const style = getComputedStyle(document.documentElement);
            const rgb = (name) => {
                const hex = style.getPropertyValue(`--${name}`).trim().replace(/^#(.)(.)(.)$/, "#$1$1$2$2$3$3");
                return [1, 3, 5].map((at) => parseInt(hex.slice(at, at + 2), 16) / 255);
            };
            const light = (name) => rgb(name).map((c) => (c <= 0.03928 ? c / 12.92 : ((c + 0.055) / 1.055) ** 2.4))
                .reduce((sum, c, i) => sum + c * [0.2126, 0.7152, 0.0722][i], 0);
            const ratio = (a, b) => (Math.max(light(a), light(b)) + 0.05) / (Math.min(light(a), light(b)) + 0.05);
            return Object.fromEntries([["text", "card"], ["faint", "card"], ["faint", "page"], ["good", "card"],
                ["on-accent", "accent"], ["text", "warn-ground"]].map(([a, b]) => [`${a} on ${b}`, ratio(a, b)]));
        });
        for (const [pair, ratio] of Object.entries(ratios)) assert.ok(ratio >= 4.5, `${colorScheme}: ${pair} ${ratio.toFixed(2)}`);
    }
});

test("A hidden page requests and draws nothing until it is visible again", async () => {
    await running(stage);
    const { page } = await openPage(stage);
    await until(() => stage.server.subscribed().includes("waveform"), "subscribed");
    const hide = (hidden) => page.evaluate((value) => {
        Object.defineProperty(document, "hidden", { value, configurable: true });
        document.dispatchEvent(new Event("visibilitychange"));
    }, hidden);
    await hide(true);
    await until(() => stage.server.subscribed().length === 0, "unsubscribed");
    const canvas = page.locator("#waveform canvas"), before = await still(() => canvas.screenshot(), "the hidden plot", 500);
    await hide(false);
    await until(() => stage.server.subscribed().includes("waveform"), "subscribed again");
    await until(async () => !before.equals(await canvas.screenshot()), "drawn again");
});

test("Pictures are requested only while they are in view", async () => {
    const { page } = await openPage(stage, { viewport: phone });
    await until(() => stage.server.subscribed().includes("waveform"), "subscribed");
    await page.waitForTimeout(1200);
    assert.ok(!stage.server.subscribed().some((stream) => stream.startsWith("camera:")));
    await page.locator("#cameras").scrollIntoViewIfNeeded();
    await until(() => ["camera:top", "camera:side"].every((stream) => stage.server.subscribed().includes(stream)), "cameras");
});
