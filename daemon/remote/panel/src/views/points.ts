// The points measured so far with their errors, and the law: Figs. 2(b) and 3(a) of the paper. Along curves of points the
// closed form; at the set-point, from the first point on, the exact law and the closed form with the band of mu's error.
import type uPlot from "uplot";
import { saveBlob } from "../actions";
import { make } from "../dom";
import { fixed, withError } from "../format";
import { axes, curves, degrees, paperG, type Curve } from "../groups";
import type { Law, LawReader, LawValues } from "../law";
import { common, Plot, xAxis, yAxis, type Columns } from "../plot";
import type { Point, SetPoint } from "../protocol";
import { pointsOf } from "../results";
import type { Store } from "../store";
import type { Theme, Themes } from "../theme";
import { offerSetPoint } from "./drive_form";
import { drawBar, drawSign, sign } from "./symbols";

const leastHeight = 0.1;  // mm/s
const nearBy = 14;  // CSS px, from a click to a point

/** The set-point of the point that was clicked. */
function clicked(u: uPlot, found: Curve[], left: number, top: number): SetPoint | null {
    let nearest = nearBy, asked: SetPoint | null = null;
    for (const point of found.flatMap((curve) => curve.points)) {
        const away = Math.hypot(u.valToPos(point.x, "x") - left, u.valToPos(point.v, "y") - top);
        if (away < nearest && point.asked) [nearest, asked] = [away, point.asked];
    }
    return asked;
}

/** The law in the units of a plot: g or degrees, and mm/s. Null: a gap. */
export interface DrawnLaw { label: string; band: boolean; x: number[]; exact: LawValues; closed: LawValues }

export function drawnLaw(law: Law, by: keyof typeof axes, refused: boolean): DrawnLaw {
    const { x, exact_mps, closed_form_mps } = law[by];
    const inMillimetres = (values: LawValues): LawValues => {
        const [at_mu, low, high] = [values.at_mu, values.low, values.high].map((all) => all.map((v) => (v === null ? null : 1e3 * v)));
        return { at_mu: at_mu!, low: low!, high: high! };
    };
    const other = by === "gamma" ? `φ = ${fixed(degrees(law.phi_rad), 0)}°` : `γ = ${fixed(law.gamma_mps2 / paperG, 2)} g`;
    return {
        label: `${other}, μ = ${withError({ value: law.mu, sigma: law.sigma || null })}${refused ? ", refused by the measurements" : ""}`, band: (law.sigma ?? 0) > 0,
        x: x.map((value) => (by === "gamma" ? value / paperG : (value * 180) / Math.PI)), exact: inMillimetres(exact_mps), closed: inMillimetres(closed_form_mps),
    };
}

function csvOf(found: Curve[], law: DrawnLaw | null, label: string): string {
    const lines = found.flatMap(({ label: curve, points }) => points.map(({ x, v, sigma, closed }) => [`"${curve}"`, x, v, sigma ?? "", closed ?? "", "", "", ""].join(",")));
    const byLaw = (law?.x ?? []).map((x, i) => [`"law at ${law!.label}"`, x, "", "", law!.closed.at_mu[i] ?? "", ...[law!.exact.at_mu, law!.exact.low, law!.exact.high].map((all) => all[i] ?? "")].join(","));
    return [`curve,"${label}","v_D, mm/s","standard error, mm/s","closed form, mm/s","exact law, mm/s","exact law, least, mm/s","exact law, greatest, mm/s"`, ...lines, ...byLaw, ""].join("\r\n");
}

type Place = (value: number) => number;

function drawLaw(ctx: CanvasRenderingContext2D, law: DrawnLaw, x: Place, y: Place, theme: Theme, ratio: number): void {
    for (const [values, dash, fill] of [[law.closed, [6, 4], "22"], [law.exact, [], "44"]] as const) {
        ctx.fillStyle = theme.closed + fill;
        for (let i = 1; i < (law.band ? law.x.length : 0); i++) {
            const sides = [values.low[i - 1], values.low[i], values.high[i], values.high[i - 1]];
            if (sides.some((v) => v == null)) continue;
            ctx.beginPath();
            sides.forEach((v, k) => ctx.lineTo(x(law.x[k === 0 || k === 3 ? i - 1 : i]!), y(v!)));
            ctx.fill();
        }
        ctx.strokeStyle = theme.closed;
        ctx.lineWidth = 1.5 * ratio;
        ctx.setLineDash(dash.map((length) => length * ratio));
        ctx.beginPath();
        values.at_mu.forEach((v, i) => { if (v !== null) ctx[values.at_mu[i - 1] == null ? "moveTo" : "lineTo"](x(law.x[i]!), y(v)); });
        ctx.stroke();
        ctx.setLineDash([]);
    }
}

function drawCurves(u: uPlot, found: Curve[], law: DrawnLaw | null, theme: Theme): void {
    const { ctx } = u, ratio = devicePixelRatio;
    const x = (value: number): number => u.valToPos(value, "x", true);
    const y = (value: number): number => u.valToPos(value, "y", true);
    ctx.save();
    ctx.beginPath();
    ctx.rect(u.bbox.left, u.bbox.top, u.bbox.width, u.bbox.height);
    ctx.clip();
    if (law) drawLaw(ctx, law, x, y, theme, ratio);
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

function showKey(list: HTMLElement, found: Curve[], law: DrawnLaw | null, theme: Theme): void {
    const items = found.map((curve, i) => {
        const look = sign(curve.single ? null : i, theme);
        return keyItem(curve.label, (ctx) => drawSign(ctx, look, 11, 7, 4.5));
    });
    const lineOf = (label: string, dash: number[]): HTMLLIElement => keyItem(label, (ctx) => {
        ctx.strokeStyle = theme.closed;
        ctx.setLineDash(dash);
        ctx.moveTo(0, 7);
        ctx.lineTo(22, 7);
        ctx.stroke();
    });
    if (law) items.push(lineOf(`exact law, ${law.label}`, []));
    if (law || found.some((curve) => !curve.single && curve.points.some(({ closed }) => closed !== null))) items.push(lineOf("closed form, no stick", [6, 4]));
    list.replaceChildren(...items);
}

/** A range that contains zero, all points with their errors, the closed form at them, and the exact law within `across`. */
function range(found: Curve[], law: DrawnLaw | null, across: [number, number]): [number, number] {
    let low = 0, high = 0;
    law?.x.forEach((x, i) => {
        if (x < across[0] || x > across[1]) return;
        low = Math.min(low, law.exact.low[i] ?? 0);
        high = Math.max(high, law.exact.high[i] ?? 0);
    });
    for (const { points } of found)
        for (const { v, sigma, closed } of points) {
            low = Math.min(low, v - (sigma ?? 0), closed ?? v);
            high = Math.max(high, v + (sigma ?? 0), closed ?? v);
        }
    high = Math.max(high, low + leastHeight);
    const room = (high - low) * 0.07;
    return [low - room, high + room];
}

/** All points, and without one the set-point. */
function width(found: Curve[], setPoint: number, least: number): [number, number] {
    const all = found.flatMap((curve) => curve.points.map((point) => point.x));
    return all.length ? padded(Math.min(...all), Math.max(...all), least) : padded(setPoint, setPoint, least);
}

export function makePoints(
    box: HTMLElement, key: HTMLElement, axis: keyof typeof axes, label: string, store: Store, lawReader: LawReader, themes: Themes,
): () => void {
    const by = axes[axis];
    let found: Curve[] = [], law: DrawnLaw | null = null;
    const across = (): [number, number] => {
        const { gamma_mps2, phi_rad } = store.state?.drive ?? { gamma_mps2: null, phi_rad: null };
        return width(found, axis === "gamma" ? (gamma_mps2 ?? paperG) / paperG : degrees(phi_rad ?? 0), by.leastSpan);
    };
    let shown = "";
    const plot = new Plot(box, themes, (theme) => ({
        ...common,
        scales: {
            x: { time: false, range: across },
            y: { range: () => range(found, law, across()) },
        },
        axes: [xAxis(theme, label), yAxis(theme, "v_D, mm/s")],
        series: [{}, { paths: () => null, points: { show: false } }],
        hooks: {
            draw: [(u) => drawCurves(u, found, law, theme)],
            ready: [(u) => u.over.addEventListener("click", ({ offsetX, offsetY }) => {
                const asked = clicked(u, found, offsetX, offsetY);
                if (asked) offerSetPoint(asked);
            })],
        },
    }));
    const name = `v_D-${box.id}`;
    const save = { PNG: () => plot.png(getComputedStyle(box.closest(".card")!).backgroundColor), CSV: async () => new Blob([csvOf(found, law, label)], { type: "text/csv" }) };
    for (const [kind, make] of Object.entries(save))
        box.parentElement!.querySelector(`button[data-save=${kind}]`)!.addEventListener("click", () => void make().then((blob) => {
            if (blob) saveBlob(blob, `${name}.${kind.toLowerCase()}`);
        }));
    let seen: readonly Point[] = [], version = -1, seenLaw: Law | null = null;
    let data: Columns = [[], []];
    return () => {
        const points = store.state?.points ?? seen;
        lawReader.follow();
        if (points === seen && version === store.resultsVersion && lawReader.law === seenLaw && !plot.stale) return;
        seen = points;
        seenLaw = lawReader.law;
        law = seenLaw && drawnLaw(seenLaw, axis, (store.state?.result.mu_refused ?? "") !== "");
        version = store.resultsVersion;
        found = curves(pointsOf(points, store.results.values()), by);
        const all = found.flatMap((curve) => curve.points).sort((a, b) => a.x - b.x);
        data = all.length ? [all.map((p) => p.x), all.map((p) => p.v)] : [[across()[0]], [null]];
        plot.draw(data);
        const words = `${themes.version} ${found.map((curve) => curve.label).join()} ${law?.label}`;
        if (words !== shown) showKey(key, found, law, themes.current);
        shown = words;
    };
}

/** Repeats at one set-point must not look like a scan: at least `least` wide. */
export function padded(low: number, high: number, least: number): [number, number] {
    const middle = (low + high) / 2, half = Math.max(((high - low) / 2) * 1.1, least / 2);
    return [middle - half, middle + half];
}
