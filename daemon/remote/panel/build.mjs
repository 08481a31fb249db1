// Makes index.html, panel.js and panel.css: node build.mjs [FOLDER]. Without a folder it writes bundle/, which CMake puts into
// shakerd.
import { build } from "esbuild";
import { copyFile, mkdir, readFile } from "node:fs/promises";
import { dirname, join, resolve } from "node:path";
import { fileURLToPath } from "node:url";

const here = dirname(fileURLToPath(import.meta.url));
const out = resolve(process.argv[2] ?? join(here, "bundle"));
const licence = await readFile(join(here, "node_modules/uplot/LICENSE"), "utf8");

await mkdir(out, { recursive: true });
await build({
    absWorkingDir: here,
    entryPoints: { panel: "src/main.ts" },
    outdir: out,
    bundle: true,
    minify: true,
    format: "iife",
    target: "es2021",
    banner: { js: `/*! uPlot\n${licence}*/` },
});
await build({
    absWorkingDir: here,
    entryPoints: { panel: "style.css" },
    outdir: out,
    bundle: true,
    minify: true,
    banner: { css: `/*! uPlot\n${licence}*/` },
});
await copyFile(join(here, "index.html"), join(out, "index.html"));
