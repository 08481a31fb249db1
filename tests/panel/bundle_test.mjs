// The committed bundle is the one that the page's sources make.
import assert from "node:assert/strict";
import { execFileSync } from "node:child_process";
import { mkdtempSync, readdirSync, readFileSync, rmSync } from "node:fs";
import { tmpdir } from "node:os";
import { join } from "node:path";
import { test } from "node:test";
import { bundle, panel } from "./sources.mjs";

test("the bundle is that of the sources, to the byte", (t) => {
    const again = mkdtempSync(join(tmpdir(), "shakerd-bundle-"));
    t.after(() => rmSync(again, { recursive: true }));
    execFileSync("npm", ["--prefix", panel, "run", "--silent", "build", "--", again], { stdio: "inherit" });
    assert.deepEqual(readdirSync(bundle), readdirSync(again));
    for (const name of readdirSync(again)) {
        const same = readFileSync(join(bundle, name)).equals(readFileSync(join(again, name)));
        assert.ok(same, `bundle/${name} is not that of its sources: npm --prefix daemon/remote/panel run build, and commit bundle/`);
    }
});
