// The points measured so far with their errors, and the closed form over them: Figs. 2(b) and 3(a) of the paper.
import type uPlot from "uplot";
import { saveBlob } from "../actions";
import { make } from "../dom";
import { curves, type axes, type Curve } from "../groups";
import { common, Plot, xAxis, yAxis, type Columns } from "../plot";
import type { Point, SetPoint } from "../protocol";
import { pointsOf } from "../results";
import type { Store } from "../store";
import type { Theme, Themes } from "../theme";
import { offerSetPoint } from "./drive_form";
import { drawSign, sign } from "./symbols";

const leastHeight = 0.1;  // mm/s
const nearBy = 14;  // CSS px, from a click to a point

function drawBar(ctx: CanvasRenderingContext2D, x: number, from: number, to: number, cap: number): void {
    ctx.beginPath();
    ctx.moveTo(x, from);
    ctx.lineTo(x, to);
    for (const y of [from, to]) {
        ctx.moveTo(x - cap, y);
        ctx.lineTo(x + cap, y);
    }
    ctx.stroke();
}

/** The set-point of the point that was clicked. */
function clicked(u: uPlot, found: Curve[], left: number, top: number): SetPoint | null {
    let nearest = nearBy, asked: SetPoint | null = null;
    for (const point of found.flatMap((curve) => curve.points)) {
        const away = Math.hypot(u.valToPos(point.x, "x") - left, u.valToPos(point.v, "y") - top);
        if (away < nearest && point.asked) [nearest, asked] = [away, point.asked];
    }
    return asked;
}

function csvOf(found: Curve[], label: string): string {
    const lines = found.flatMap(({ label: curve, points }) => points.map(({ x, v, sigma, closed }) => [`"${curve}"`, x, v, sigma ?? "", closed ?? ""].join(",")));
    return [`curve,"${label}","v_D, mm/s","standard error, mm/s","closed form, mm/s"`, ...lines, ""].join("\r\n");
}

function drawCurves(u: uPlot, found: Curve[], theme: Theme): void {
    const { ctx } = u, ratio = devicePixelRatio;
    const x = (value: number): number => u.valToPos(value, "x", true);
    const y = (value: number): number => u.valToPos(value, "y", true);
    ctx.save();
    ctx.beginPath();
    ctx.rect(u.bbox.left, u.bbox.top, u.bbox.width, u.bbox.height);
    ctx.clip();
    found.forEach((curve, i) => {
        const look = sign(curve.single ? null : i, theme);
        ctx.lineWidth = 1.5 * ratio;
        ctx.strokeStyle = look.colour;
        ctx.setLineDash([6 * ratio, 4 * ratio]);
        ctx.beginPath();
        for (const point of curve.single ? [] : curve.points)
            if (point.closed !== null) ctx.lineTo(x(point.x), y(point.closed));
        ctx.stroke();
        ctx.setLineDash([]);
        for (const point of curve.points) {
            if (point.sigma !== null) drawBar(ctx, x(point.x), y(point.v - point.sigma), y(point.v + point.sigma), 3 * ratio);
            drawSign(ctx, look, x(point.x), y(point.v), 4.5 * ratio);
        }
    });
    ctx.restore();
}

function keyItem(label: string, draw: (ctx: CanvasRenderingContext2D) => void): HTMLLIElement {
    const item = make("li"), canvas = make("canvas");
    const ratio = devicePixelRatio;
    canvas.width = 22 * ratio;
    canvas.height = 14 * ratio;
    canvas.style.width = "22px";
    canvas.style.height = "14px";
    const ctx = canvas.getContext("2d");
    if (ctx) {
        ctx.scale(ratio, ratio);
        ctx.lineWidth = 1.5;
        draw(ctx);
    }
    item.append(canvas, label);
    return item;
}

function showKey(list: HTMLElement, found: Curve[], theme: Theme): void {
    const items = found.map((curve, i) => {
        const look = sign(curve.single ? null : i, theme);
        return keyItem(curve.label, (ctx) => drawSign(ctx, look, 11, 7, 4.5));
    });
    const closed = keyItem("closed form, no stick", (ctx) => {
        ctx.strokeStyle = theme.closed;
        ctx.setLineDash([6, 4]);
        ctx.moveTo(0, 7);
        ctx.lineTo(22, 7);
        ctx.stroke();
    });
    list.replaceChildren(...items, closed);
}

/** A range that contains zero, all points with their errors, and the closed form. */
function range(found: Curve[]): [number, number] {
    let low = 0, high = 0;
    for (const { points } of found)
        for (const { v, sigma, closed } of points) {
            low = Math.min(low, v - (sigma ?? 0), closed ?? v);
            high = Math.max(high, v + (sigma ?? 0), closed ?? v);
        }
    high = Math.max(high, low + leastHeight);
    const room = (high - low) * 0.07;
    return [low - room, high + room];
}

function width(found: Curve[], least: number): [number, number] {
    const all = found.flatMap((curve) => curve.points.map((point) => point.x));
    return all.length ? padded(Math.min(...all), Math.max(...all), least) : [0, 1];
}

export function makePoints(
    box: HTMLElement, key: HTMLElement, by: (typeof axes)["gamma"], label: string, store: Store, themes: Themes,
): () => void {
    let found: Curve[] = [];
    let shown = "";
    const plot = new Plot(box, themes, (theme) => ({
        ...common,
        scales: {
            x: { time: false, range: () => width(found, by.leastSpan) },
            y: { range: () => range(found) },
        },
        axes: [xAxis(theme, label), yAxis(theme, "v_D, mm/s")],
        series: [{}, { paths: () => null, points: { show: false } }],
        hooks: {
            draw: [(u) => drawCurves(u, found, theme)],
            ready: [(u) => u.over.addEventListener("click", ({ offsetX, offsetY }) => {
                const asked = clicked(u, found, offsetX, offsetY);
                if (asked) offerSetPoint(asked);
            })],
        },
    }));
    const name = `v_D-${box.id}`;
    const save = { PNG: () => plot.png(getComputedStyle(box.closest(".card")!).backgroundColor), CSV: async () => new Blob([csvOf(found, label)], { type: "text/csv" }) };
    for (const [kind, make] of Object.entries(save))
        box.parentElement!.querySelector(`button[data-save=${kind}]`)!.addEventListener("click", () => void make().then((blob) => {
            if (blob) saveBlob(blob, `${name}.${kind.toLowerCase()}`);
        }));
    let seen: readonly Point[] = [], version = -1;
    let data: Columns = [[], []];
    return () => {
        const points = store.state?.points ?? seen;
        if (points === seen && version === store.resultsVersion && !plot.stale) return;
        seen = points;
        version = store.resultsVersion;
        found = curves(pointsOf(points, store.results.values()), by);
        const all = found.flatMap((curve) => curve.points).sort((a, b) => a.x - b.x);
        data = [all.map((p) => p.x), all.map((p) => p.v)];
        plot.draw(data);
        const words = `${themes.version} ${found.map((curve) => curve.label).join()}`;
        if (words !== shown) showKey(key, found, themes.current);
        shown = words;
    };
}

/** Repeats at one set-point must not look like a scan: at least `least` wide. */
export function padded(low: number, high: number, least: number): [number, number] {
    const middle = (low + high) / 2, half = Math.max(((high - low) / 2) * 1.1, least / 2);
    return [middle - half, middle + half];
}
