// The points measured so far with their errors, and the closed form over them: Figs. 2(b) and 3(a) of the paper.
import type uPlot from "uplot";
import { make } from "../dom";
import { curves, type axes, type Curve } from "../groups";
import { common, Plot, xAxis, yAxis, type Columns } from "../plot";
import type { Point } from "../protocol";
import type { Store } from "../store";
import type { Theme, Themes } from "../theme";
import { drawSign, sign } from "./symbols";

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
            if (point.sigma !== null) {
                ctx.beginPath();
                ctx.moveTo(x(point.x), y(point.v - point.sigma));
                ctx.lineTo(x(point.x), y(point.v + point.sigma));
                ctx.stroke();
            }
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
    const room = (high - low || 1) * 0.07;
    return [low - room, high + room];
}

export function makePoints(
    box: HTMLElement, key: HTMLElement, by: (typeof axes)["gamma"], label: string, store: Store, themes: Themes,
): () => void {
    let found: Curve[] = [];
    let shown = "";
    const plot = new Plot(box, themes, (theme) => ({
        ...common,
        scales: {
            x: { time: false, range: (_u, low, high) => padded(low ?? 0, high ?? 1) },
            y: { range: () => range(found) },
        },
        axes: [xAxis(theme, label), yAxis(theme, "v_D, mm/s")],
        series: [{}, { paths: () => null, points: { show: false } }],
        hooks: { draw: [(u) => drawCurves(u, found, theme)] },
    }));
    let seen: readonly Point[] = [];
    let data: Columns = [[], []];
    return () => {
        const points = store.state?.points ?? seen;
        if (points === seen && !plot.stale) return;
        seen = points;
        found = curves(points, by);
        const all = found.flatMap((curve) => curve.points).sort((a, b) => a.x - b.x);
        data = [all.map((p) => p.x), all.map((p) => p.v)];
        plot.draw(data);
        const words = `${themes.version} ${found.map((curve) => curve.label).join()}`;
        if (words !== shown) showKey(key, found, themes.current);
        shown = words;
    };
}

function padded(low: number, high: number): [number, number] {
    const room = (high - low) * 0.05 || Math.max(0.1, Math.abs(low) * 0.1);
    return [low - room, high + room];
}
