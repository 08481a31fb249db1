import assert from "node:assert/strict";
import { spawn } from "node:child_process";
import { mkdtempSync, writeFileSync } from "node:fs";
import { tmpdir } from "node:os";
import { join } from "node:path";
import { project } from "./sources.mjs";

const program = process.env.SHAKERD ?? join(project, "build/dev/shakerd");

async function end(child) {
    const gone = new Promise((resume) => child.on("exit", resume));
    child.kill("SIGTERM");
    await gone;
}

/** The real daemon on the simulated bench, on free ports, which it prints on standard error. phi in rad; `scene`: TOML; port: of HTTP, 0: a free one. */
export async function startDaemon(phi, scene = "", port = 0) {
    const recordings = mkdtempSync(join(tmpdir(), "shakerd-page-"));
    const settings = join(recordings, "settings.toml");
    writeFileSync(settings, `[run]\nphi_rad = ${phi}\nperiods = 20\n`);
    const scenes = scene ? ["--scene", join(recordings, "scene.toml")] : [];
    if (scene) writeFileSync(scenes[1], scene);
    const child = spawn(program, ["serve", "--settings", settings, "--http-port", String(port), "--scpi-port", "0",
        "--recordings", recordings, ...scenes], { stdio: ["ignore", "inherit", "pipe"] });
    let said = "";
    child.stderr.on("data", (bytes) => { said += bytes; });
    for (const late = Date.now() + 20_000; ;) {
        const found = /http:\/\/127\.0\.0\.1:(\d+)\//.exec(said);
        const scpi = /instrument language: 127\.0\.0\.1 port (\d+)/.exec(said);
        if (found && scpi) return { child, port: Number(found[1]), scpi: Number(scpi[1]), said: () => said, end: () => end(child) };
        assert.ok(Date.now() < late && child.exitCode === null, `the daemon did not come up: ${said}`);
        await new Promise((resume) => setTimeout(resume, 50));
    }
}
