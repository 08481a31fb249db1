// Regions of targets moved over the pictures, on the played bench and with the real daemon.
import assert from "node:assert/strict";
import { mkdirSync } from "node:fs";
import { join } from "node:path";
import test, { after, afterEach, before, beforeEach } from "node:test";
import { startDaemon } from "./daemon.mjs";
import { idle, openPage, phone, running, setStage, until } from "./stage.mjs";

const folder = process.env.PANEL_SCREENSHOTS, wide = { width: 1440, height: 1000 };
let stage, server;
before(async () => {
    stage = await setStage();
    ({ server } = stage);
});
after(() => stage.clear());
afterEach(() => stage.closePages());
beforeEach(async () => {
    server.refuse = null;
    server.bench.regions = { top: [170, 30, 120, 110], side: [170, 20, 120, 90] };
    server.bench.walker_lost = false;
    server.bench.not_found = null;
    await idle(stage);
    server.requests.length = 0;
});

const press = (page, name) => page.getByRole("button", { name, exact: true }).click();
const box = (page, camera = 0) => page.locator("#cameras figure").nth(camera).locator(".target-box[data-kind=walker]");
const words = (page, camera) => box(page, camera).textContent();
const sent = async () => {
    await until(() => server.requests.at(-1)?.name === "targets", "POST targets");
    return server.requests.at(-1).body.targets;
};
async function open(page) {
    await page.locator("#cameras-card").scrollIntoViewIfNeeded();
    await until(async () => /walker (tracked|lost)/.test(await page.textContent("#cameras")), "the pictures");
    await press(page, "Move targets");
    await box(page).waitFor();
}
async function drag(page, place, dx, dy) {
    const { x, y, width, height } = await place.boundingBox();
    await page.mouse.move(x + width / 2, y + height / 2);
    await page.mouse.down();
    await page.mouse.move(x + width / 2 + dx, y + height / 2 + dy, { steps: 4 });
    await page.mouse.up();
}

test("A box is dragged and resized, and one order sends the changed regions", async () => {
    const { page, troubles } = await openPage(stage, { viewport: wide });
    await open(page);
    assert.equal(await words(page), "walker 170, 30, 120 × 110 px");
    const picture = await page.locator("#cameras canvas").first().boundingBox(), at = await box(page).boundingBox();
    const across = picture.width, zoom = across / 1280;
    assert.deepEqual([at.x - picture.x, at.y - picture.y, at.width, at.height].map(Math.round), [170, 30, 120, 110].map((length) => Math.round(length * zoom)), "over its region");
    const px = (css) => Math.round((css * 1280) / across);
    await drag(page, box(page), 50, 8);
    assert.equal(await words(page), `walker ${170 + px(50)}, ${30 + px(8)}, 120 × 110 px`);
    await drag(page, box(page).locator("i"), 20, 10);
    await press(page, "Use these regions");
    assert.deepEqual(await sent(), [{ camera: "top", target: "walker", region_px: [170 + px(50), 30 + px(8), 120 + px(20), 110 + px(10)] }]);
    await box(page).waitFor({ state: "detached" });
    await page.getByText("until the daemon ends").waitFor();
    assert.deepEqual(troubles, []);
});

test("Arrow keys move the focused box in the picture, with Shift they change its size", async () => {
    const { page } = await openPage(stage, { viewport: wide });
    await open(page);
    await box(page, 1).focus();
    for (const key of ["ArrowRight", "ArrowRight", "ArrowUp", "Shift+ArrowDown", "Shift+ArrowLeft"]) await page.keyboard.press(key);
    assert.equal(await words(page, 1), "walker 172, 19, 119 × 91 px");
    for (let k = 0; k < 25; k++) await page.keyboard.press("ArrowUp");
    assert.equal(await words(page, 1), "walker 172, 0, 119 × 91 px");
    assert.match(await page.locator("#targets-note").textContent(), /Arrow keys move/);
    await press(page, "Cancel");
    await box(page).waitFor({ state: "detached" });
    assert.equal(server.requests.length, 0);
});

test("The page prints below a picture why its target was not found", async () => {
    server.bench.not_found = { top: "camera top, target walker, roi_px [170, 30, 120, 110]: found no bright disc of 50 px" };
    const { page, troubles } = await openPage(stage, { viewport: wide });
    await page.locator("#cameras-card").scrollIntoViewIfNeeded();
    await page.getByText('found no bright disc of 50 px; press "Move targets"').waitFor();
    await open(page);
    assert.deepEqual(troubles, []);
});

test("A refusal stays beside the buttons, and the boxes stay open", async () => {
    const { page } = await openPage(stage, { viewport: wide });
    await open(page);
    await press(page, "Use these regions");
    await page.locator("#targets output").getByText("no region was moved").waitFor();
    await box(page).focus();
    for (let k = 0; k < 90; k++) await page.keyboard.press("Shift+ArrowLeft");
    await press(page, "Use these regions");
    await page.locator("#targets output").getByText('camera "top", target "walker", roi_px [170, 30, 30, 110]: not found').waitFor();
    assert.equal(await box(page).count(), 1);
});

test("A proposal is dashed until it is used; a lost target has none", async () => {
    const { page } = await openPage(stage, { viewport: wide });
    await open(page);
    await press(page, "Propose");
    assert.equal(await words(page), "walker 470, 30, 120 × 110 px");
    assert.equal(await box(page).evaluate((e) => getComputedStyle(e).outlineStyle), "dashed");
    await press(page, "Use these regions");
    assert.deepEqual((await sent()).map(({ camera, region_px }) => [camera, region_px[0]]), [["top", 470], ["side", 470]]);
    server.bench.walker_lost = true;
    await open(page);
    await until(async () => {
        await press(page, "Propose");
        return /^Not found in the picture: walker of camera top, walker of camera side\./.test(await page.locator("#targets-note").textContent());
    }, "the page knows that it is lost");
});

test("Targets are moved at rest only, and a start closes the boxes", async () => {
    const { page } = await openPage(stage, { viewport: wide });
    await open(page);
    await running(stage);
    await box(page).waitFor({ state: "detached" });
    assert.ok(await page.locator("#targets-move").isDisabled());
});

test("A real bench shows the lines for its rig file", async () => {
    const { bench } = server, message = Object.getPrototypeOf(bench).message;
    bench.message = () => { const all = message.call(bench); return { ...all, session: { ...all.session, simulated: false } }; };
    const { page } = await openPage(stage, { viewport: wide });
    await open(page);
    await box(page).focus();
    await page.keyboard.press("ArrowRight");
    await press(page, "Use these regions");
    await page.locator("#targets-lines").waitFor();
    assert.equal(await page.locator("#targets-lines").textContent(), '# [[camera]] name = "top", [[camera.target]] name = "walker"\nroi_px = [171, 70, 120, 110]');
    delete bench.message;
});

for (const [name, viewport] of [["wide", wide], ["phone", phone]])
    for (const colorScheme of ["light", "dark"])
        test(`Boxes and buttons fit a ${name} screen in ${colorScheme} colours`, async () => {
            const { page, troubles } = await openPage(stage, { viewport, colorScheme });
            await open(page);
            assert.equal(await page.evaluate(() => document.documentElement.scrollWidth - innerWidth), 0);
            await press(page, "Propose");
            if (folder) {
                mkdirSync(folder, { recursive: true });
                await page.screenshot({ path: join(folder, `targets-${name}-${colorScheme}.png`) });
            }
            assert.deepEqual(troubles, []);
        });

test("The real daemon takes a region that holds its target, and refuses another one", { timeout: 120_000 }, async () => {
    const daemon = await startDaemon(1.75);
    after(() => daemon.end());
    const { page } = await openPage({ server: { port: daemon.port }, browser: stage.browser }, { hash: "", viewport: wide });
    const region = async () => (await (await page.request.get(`http://127.0.0.1:${daemon.port}/api/state`)).json()).cameras[0].targets[0].region_px;
    const first = await region();
    await open(page);
    await box(page).focus();
    for (const key of ["ArrowLeft", "ArrowLeft", "Shift+ArrowRight", "Shift+ArrowRight", "Shift+ArrowRight"]) await page.keyboard.press(key);
    if (folder) await page.screenshot({ path: join(folder, "targets-daemon.png") });
    await press(page, "Use these regions");
    const asked = [first[0] - 2, first[1], first[2] + 3, first[3]];
    await until(async () => (await region()).join() === asked.join(), "the daemon's state has the region");
    await until(() => daemon.said().includes(`targets moved until the daemon ends: camera "top", target "walker", roi_px = [${asked.join(", ")}] by page`), "the log has one line");
    await open(page);
    await drag(page, box(page), 200, 0);
    await press(page, "Use these regions");
    await page.locator("#targets output").getByText("camera top, target walker, roi_px").waitFor();
    if (folder) await page.screenshot({ path: join(folder, "targets-refused.png") });
    assert.deepEqual(await region(), asked);
});

test("A real daemon that does not find its walker at the start drives once its region is moved", { timeout: 120_000 }, async () => {
    const daemon = await startDaemon(1.75, "[top]\nregion_off_px = 90\n");
    after(() => daemon.end());
    const { page } = await openPage({ server: { port: daemon.port }, browser: stage.browser }, { hash: "", viewport: wide });
    await page.getByText('press "Move targets"').waitFor();
    await page.getByRole("button", { name: "Start", exact: true }).click();
    await page.getByText("a run cannot start: camera top, target walker, roi_px").first().waitFor();
    await open(page);
    if (folder) await page.screenshot({ path: join(folder, "targets-not-found.png") });
    await box(page).focus();
    for (let k = 0; k < 90; k++) await page.keyboard.press("ArrowLeft");
    await press(page, "Use these regions");
    await until(() => daemon.said().includes('camera "top": its targets are found'), "the log tells that they are found");
    await page.getByRole("button", { name: "Start", exact: true }).click();
    const state = async () => (await (await page.request.get(`http://127.0.0.1:${daemon.port}/api/state`)).json()).session.state;
    await until(async () => (await state()) === "running", "the bench is running", 30_000);  // after identification and ramp
});
