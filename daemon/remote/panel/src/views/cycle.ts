// x(t) and v(t) of the walker averaged over the periods, with v_B: Fig. 2 of the paper. Bands are one standard error.
import type uPlot from "uplot";
import { channel, type SampleFrame } from "../frames";
import { atLeast, common, dashes, line, Plot, xAxis, yAxis, type Columns } from "../plot";
import type { Store } from "../store";
import type { Theme, Themes } from "../theme";

const metre = 1e3;  // in mm

function banded(frame: SampleFrame, mean: number, error: number): Columns {
    const centre = channel(frame, mean, metre), width = channel(frame, error, metre);
    const edge = (sign: number): (number | null)[] =>
        centre.map((value, i) => (value === null ? null : value + sign * (width[i] ?? 0)));
    return [edge(1), edge(-1), centre];
}

function band(theme: Theme): { series: [number, number]; fill: string }[] {
    return [{ series: [1, 2], fill: `${theme.walker}55` }];
}

const phase: uPlot.Scale = { time: false, range: [0, 1] };
const hidden = { points: { show: false }, width: 0 };

export function makeCycle(xBox: HTMLElement, vBox: HTMLElement, store: Store, themes: Themes): () => void {
    const x = new Plot(xBox, themes, (theme) => ({
        ...common,
        scales: { x: phase, y: atLeast(0.01) },
        axes: [xAxis(theme, "", { size: 20, labelSize: 4 }), yAxis(theme, "x, mm")],
        series: [{}, hidden, hidden, line(theme.walker, dashes.solid)],
        bands: band(theme),
    }));
    const v = new Plot(vBox, themes, (theme) => ({
        ...common,
        scales: { x: phase, y: atLeast(1) },
        axes: [xAxis(theme, "t/T"), yAxis(theme, "v, mm/s")],
        series: [{}, hidden, hidden, line(theme.walker, dashes.solid), line(theme.base, dashes.dashed, 1.5)],
        bands: band(theme),
    }));
    let seen: SampleFrame | null = null;
    let columns: { x: Columns; v: Columns } = { x: [[], [], [], []], v: [[], [], [], [], []] };
    return () => {
        if (seen === store.cycle && !x.stale && !v.stale) return;
        const frame = (seen = store.cycle);
        if (frame) {
            const turns = Array.from({ length: frame.count }, (_, i) => (i + 0.5) / frame.count);
            columns = {
                x: [turns, ...banded(frame, 0, 1)],
                v: [turns, ...banded(frame, 2, 3), channel(frame, 4, metre)],
            };
        }
        x.draw(columns.x);
        v.draw(columns.v);
    };
}
