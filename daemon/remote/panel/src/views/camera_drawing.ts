// Drawings over a camera's picture: tracked and lost targets, regions of search, limits at the edge, scale bar.
import { duration, number } from "../format";
import type { Mark, PictureFrame } from "../frames";
import type { Camera, Known } from "../protocol";

/** Lines on pictures are independent of the theme: light with a dark rim. */
const looks: { name: string; colour: string; dash: number[] }[] = [
    { name: "walker", colour: "#e69f00", dash: [] },
    { name: "base", colour: "#56b4e9", dash: [] },
    { name: "other", colour: "#cc79a7", dash: [] },
];
const regionDash = [2, 4], lostDash = [8, 5], limitColour = "#ff8a5c", plain = "#ffffff";
export const states = ["", "degraded", "lost", "found again", "clipped", "perhaps at a neighbour's place", "repeated picture"];

export const look = (kind: number): { name: string; colour: string } => looks[Math.min(kind & 15, looks.length - 1)]!;
/** Nothing of this picture shows the target. */
export const isLost = (kind: number): boolean => [2, 6].includes(kind >> 4);
export const stateOf = (kind: number): string => states[(kind >> 4) & 15] ?? "";

interface Box { x: number; y: number; width: number; height: number }
/** Where a target was when it was last found, and when: s of master time. */
export interface Seen { mark: Mark; t: number }

function strokeBox(ctx: CanvasRenderingContext2D, { x, y, width, height }: Box, colour: string, dash: number[]): void {
    for (const [stroke, thick, lines] of [["#000", 4, []], [colour, 2, dash]] as const) {
        ctx.strokeStyle = stroke;
        ctx.lineWidth = thick;
        ctx.setLineDash(lines);
        ctx.strokeRect(x, y, width, height);
    }
    ctx.setLineDash([]);
}

function write(ctx: CanvasRenderingContext2D, words: string, x: number, y: number, colour: string): void {
    ctx.font = "12px system-ui, sans-serif";
    ctx.lineWidth = 3;
    ctx.strokeStyle = "#000";
    ctx.fillStyle = colour;
    ctx.strokeText(words, x, y);
    ctx.fillText(words, x, y);
}

/** The target where it is, or, lost, where it was last: dashed, with the time since. `zoom`: CSS px per px of the mark. */
export function drawTarget(ctx: CanvasRenderingContext2D, kind: number, seen: Seen, now: number, zoom: number): void {
    const { mark, t } = seen, { name, colour } = look(kind);
    const lost = isLost(kind), box = { x: mark.x * zoom, y: mark.y * zoom, width: mark.width * zoom, height: mark.height * zoom };
    strokeBox(ctx, box, colour, lost ? lostDash : []);
    const state = lost ? `${stateOf(kind)} for ${duration(now - t)}` : stateOf(kind);
    write(ctx, state ? `${name}: ${state}` : name, box.x + 2, box.y > 16 ? box.y - 5 : box.y + 14, colour);
}

/** Distances from the picture's left and right end (upper and lower, if x runs along its height), CSS px. Empty: not known. */
export function edgeLines(camera: Camera, limitMetres: unknown, pxPerMm: number, size: { width: number; height: number }): { upright: boolean; at: number[] } {
    const upright = Math.abs(camera.along[0]) >= Math.abs(camera.along[1]), length = upright ? size.width : size.height;
    if (typeof limitMetres !== "number" || !camera.targets.some(({ name }) => name === "walker")) return { upright, at: [] };
    const margin = 1e3 * limitMetres * pxPerMm;
    return { upright, at: margin > 0 && margin < length / 2 ? [margin, length - margin] : [] };
}

/** The longest of 1, 2, 5, 10, ... mm that takes at most a fifth of the width. */
export function scaleBar(pxPerMm: number, width: number): { mm: number; px: number } {
    const most = width / 5 / pxPerMm, decade = 10 ** Math.floor(Math.log10(most));
    const mm = [5, 2, 1].map((k) => k * decade).find((length) => length <= most) ?? decade;
    return { mm, px: mm * pxPerMm };
}

/** Limits and regions. `size`: CSS px of the picture. */
export function drawGeometry(ctx: CanvasRenderingContext2D, camera: Camera, limitMetres: unknown, size: { width: number; height: number }): void {
    if (!camera.mm_per_px || !camera.width_px) return;
    const zoom = size.width / camera.width_px, pxPerMm = zoom / camera.mm_per_px;
    for (const { region_px: [x, y, width, height] } of camera.targets)
        if (width > 0) strokeBox(ctx, { x: x * zoom, y: y * zoom, width: width * zoom, height: height * zoom }, plain, regionDash);
    const { upright, at } = edgeLines(camera, limitMetres, pxPerMm, size);
    ctx.strokeStyle = limitColour;
    ctx.lineWidth = 2;
    for (const line of at) {
        ctx.beginPath();
        ctx.moveTo(upright ? line : 0, upright ? 0 : line);
        ctx.lineTo(upright ? line : size.width, upright ? size.height : line);
        ctx.stroke();
    }
}

/** A scale bar on a dark ground, at the lower right. */
export function drawScale(ctx: CanvasRenderingContext2D, camera: Camera, size: { width: number; height: number }): void {
    if (!camera.mm_per_px || !camera.width_px) return;
    const bar = scaleBar(size.width / camera.width_px / camera.mm_per_px, size.width), words = `${number(bar.mm, 1)} mm`;
    ctx.font = "12px system-ui, sans-serif";
    const across = Math.max(bar.px, ctx.measureText(words).width) + 12, x = size.width - across;
    ctx.fillStyle = "#000a";
    ctx.fillRect(x, size.height - 22, across, 22);
    ctx.fillStyle = plain;
    ctx.fillText(words, x + 6, size.height - 9);
    ctx.fillRect(x + 6, size.height - 5, bar.px, 2);
}

/** "exposed for 0.20 ms, 0.3 % clipped, edges 2.1 px". */
export function figureWords({ exposure_s, clipped, edge_px }: Pick<Camera, "exposure_s" | "clipped" | "edge_px">): string {
    const words: string[] = [];
    const say = (value: Known, text: (known: number) => string): void => { if (value !== null) words.push(text(value)); };
    say(exposure_s, (s) => (s > 0 ? `exposed for ${number(1e3 * s, 2)} ms` : ""));
    say(clipped, (share) => `${share > 0.01 ? "⚠ " : ""}${number(100 * share, 2)} % clipped`);
    say(edge_px, (px) => `${px > 6 ? "⚠ blurred: " : ""}edges ${number(px, 2)} px`);
    return words.filter((text) => text !== "").join(", ");
}

export function targetWords(frame: PictureFrame): string {
    return frame.marks.map((mark) => `${look(mark.kind).name} ${stateOf(mark.kind) || "tracked"}`).join(", ") || "no target found";
}
