// The page with the daemon itself behind it, on the simulated bench: what an operator does, in a real browser.
import assert from "node:assert/strict";
import { spawn } from "node:child_process";
import { mkdtempSync, writeFileSync } from "node:fs";
import { tmpdir } from "node:os";
import { join } from "node:path";
import test, { after, before } from "node:test";
import { openBrowser, openPage } from "./stage.mjs";
import { project } from "./sources.mjs";

const program = process.env.SHAKERD ?? join(project, "build/dev/shakerd");
const folder = process.env.PANEL_SCREENSHOTS;
let daemon, stage;

/** Started on ports that are free; says them on its standard error. */
async function startDaemon() {
    const recordings = mkdtempSync(join(tmpdir(), "shakerd-page-"));
    const settings = join(recordings, "settings.toml");
    writeFileSync(settings, "[run]\nphi_rad = 1.75\nperiods = 20\n");  // a slow walker: seconds until it is at the edge
    const child = spawn(program, ["serve", "--settings", settings, "--http-port", "0", "--scpi-port", "0", "--page", join(project, "build/panel"),
        "--recordings", recordings], { stdio: ["ignore", "inherit", "pipe"] });
    let said = "";
    child.stderr.on("data", (bytes) => { said += bytes; });
    for (const end = Date.now() + 20_000; ;) {
        const found = /http:\/\/127\.0\.0\.1:(\d+)\//.exec(said);
        if (found) return { child, port: Number(found[1]), said: () => said };
        assert.ok(Date.now() < end && child.exitCode === null, `the daemon did not come up: ${said}`);
        await new Promise((resume) => setTimeout(resume, 50));
    }
}

before(async () => {
    daemon = await startDaemon();
    stage = { server: { port: daemon.port }, browser: await openBrowser() };
});
after(async () => {
    await stage?.browser.close();
    if (!daemon) return;
    const gone = new Promise((resume) => daemon.child.on("exit", resume));
    daemon.child.kill("SIGTERM");
    await gone;
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
