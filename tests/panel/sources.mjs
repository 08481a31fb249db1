// The page's modules in a form that node can load, and the installed packages.
import { createRequire } from "node:module";
import { join, resolve } from "node:path";
import { fileURLToPath, pathToFileURL } from "node:url";

export const project = fileURLToPath(new URL("../../", import.meta.url));
export const panel = join(project, "daemon/remote/panel");
export const bundle = join(panel, "bundle");
const require = createRequire(join(panel, "package.json"));

export const { chromium } = require("playwright-core");

/** The exports of src/<name>.ts. */
export async function source(name) {
    const { build } = require("esbuild");
    const outfile = resolve(project, `build/panel_tests/${name}.mjs`);
    await build({ entryPoints: [join(panel, `src/${name}.ts`)], outfile, bundle: true, format: "esm", logLevel: "error" });
    return import(pathToFileURL(outfile).href);
}
