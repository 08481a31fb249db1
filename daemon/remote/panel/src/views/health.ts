// Health of the measurement: clocks, losses, disk, jitter, limits.
import uPlot from "uplot";
import { byId, setRows, setText } from "../dom";
import { fixed, number, prefixed, unknown } from "../format";
import { common, Plot, xAxis, yAxis, type Columns } from "../plot";
import type { Clock, Jitter, Known, Loss, RealTimeGrant, State, Switches, Tracking } from "../protocol";
import type { Store } from "../store";
import type { Themes } from "../theme";

function clockRow(clock: Clock): string[] {
    const ppm = clock.ppm === null ? unknown : (clock.ppm > 0 ? "+" : "") + fixed(clock.ppm, 3);
    return [clock.name, ppm, prefixed(clock.residual_s, "s")];
}

function lossRow(loss: Loss): string[] {
    return [loss.stream, loss.got.toLocaleString("en"), loss.lost ? `⚠ ${loss.lost.toLocaleString("en")}` : "0"];
}

function limitRow([name, value]: [string, unknown]): string[] {
    return [name.replaceAll("_", " "), typeof value === "number" ? number(value) : JSON.stringify(value)];
}

/** Number of each bin and its count. Empty bins have no bar, because the axis of counts is logarithmic. */
function jitterColumns(jitter: Jitter): Columns {
    return [jitter.counts.map((_, i) => i), jitter.counts.map((count) => count || null)];
}

const barPaths = uPlot.paths.bars!({ size: [0.8, 40] });

function edgeWords(bins: number[], index: number): string {
    if (index < bins.length) return prefixed(bins[index], "s", 1);
    return "more";
}

/** Filled share of the recorder's queue. */
function share(backlog: Known): string {
    return backlog === null ? unknown : `${fixed(100 * backlog, 0)} % of its queue`;
}

/** What the tracking of pictures takes. */
export function trackingWords(tracking: Tracking): string {
    if (tracking.core_share === null) return "no pictures";
    const share = `${fixed(100 * tracking.core_share, 1)} % of a processor`;
    return `${share}, 99.9 % below ${prefixed(tracking.slowest_s, "s", 1)}`;
}

/** Refused requests for real time, or "granted"; a simulated bench makes none. */
export function realTimeWords(grants: RealTimeGrant[]): string {
    if (!grants.length) return "not requested";
    const refused = grants.filter((grant) => grant.refused !== null);
    return refused.length ? `⚠ refused: ${refused.map((grant) => grant.what).join(", ")}` : "granted";
}

/** State of the abort input's contact; only a closed one is well. */
export function contactWords(contact: Switches["abort_contact"]): string {
    if (contact === null) return "none";
    return contact === "closed" ? contact : `⚠ ${contact}`;
}

function enableWords(on: Switches["enable_output"]): string {
    if (on === null) return "none";
    return on ? "on" : "off";
}

export function makeHealth(box: HTMLElement, store: Store, themes: Themes): () => void {
    const free = byId("disk-free", HTMLElement), lag = byId("disk-lag", HTMLElement);
    const worst = byId("jitter-worst", HTMLElement), missed = byId("page-missed", HTMLElement);
    const realTime = byId("real-time", HTMLElement), tracking = byId("tracking-share", HTMLElement);
    const contact = byId("abort-contact", HTMLElement), enable = byId("enable-output", HTMLElement);
    const clocks = byId("clocks", HTMLTableSectionElement), losses = byId("losses", HTMLTableSectionElement);
    const limits = byId("limits", HTMLTableSectionElement);
    const draw = makeJitter(box, store, themes);
    let seen = -1;
    const show = (state: State): void => {
        setText(free, prefixed(state.disk.free_bytes, "B"));
        setText(lag, share(state.disk.backlog));
        setText(tracking, trackingWords(state.tracking));
        setText(worst, prefixed(state.jitter.worst_s, "s"));
        setText(missed, `${store.missed} gaps` + (store.unreadable ? `, ${store.unreadable} unreadable` : ""));
        setText(realTime, realTimeWords(state.real_time));
        realTime.title = state.real_time.flatMap((grant) => grant.refused ?? []).join("\n");
        setText(contact, contactWords(state.switches.abort_contact));
        setText(enable, enableWords(state.switches.enable_output));
        setRows(clocks, state.clocks.map(clockRow));
        setRows(losses, state.losses.map(lossRow));
        setRows(limits, Object.entries(state.limits).map(limitRow));
    };
    return () => {
        if (store.state && seen !== store.stateVersion) show(store.state);
        seen = store.stateVersion;
        draw();
    };
}

function makeJitter(box: HTMLElement, store: Store, themes: Themes): () => void {
    let bins: number[] = [];
    const plot = new Plot(box, themes, (theme) => ({
        ...common,
        scales: {
            x: { time: false, range: (_u, low, high) => [(low ?? 0) - 0.6, (high ?? 1) + 0.6] },
            y: { distr: 3, range: (_u, _low, high) => [0.5, Math.max(10, (high ?? 1) * 2)] },
        },
        axes: [
            xAxis(theme, "wake-up late by less than", {
                grid: { show: false }, incrs: [1, 2, 3, 4, 5, 10], space: 48,
                values: (_u, splits) => splits.map((i) => (Number.isInteger(i) ? edgeWords(bins, i) : "")),
            }),
            yAxis(theme, "count", { grid: { show: false }, ticks: { show: false } }),
        ],
        series: [{}, {
            stroke: theme["series-1"], fill: `${theme["series-1"]}99`, width: 1, points: { show: false },
            paths: barPaths,
        }],
    }));
    let drawn = "";
    return () => {
        const jitter = store.state?.jitter;
        if (!jitter) return;
        const now = JSON.stringify(jitter.counts);
        if (now === drawn && !plot.stale) return;
        drawn = now;
        bins = jitter.bins_s;
        plot.draw(jitterColumns(jitter));
    };
}
