// Live curves of the last seconds: positions of walker and base, and the acceleration. When several points fall on one
// pixel, their least and greatest values are drawn.
import type uPlot from "uplot";
import { atLeast, common, dashes, line, Plot, xAxis, yAxis, type Columns } from "../plot";
import type { Rolling } from "../rolling";
import type { Theme, Themes } from "../theme";

const window = 20;  // s

/** `filled`: the area between least and greatest value is filled. */
interface Look { channel: number; colour: keyof Theme; dash: number[]; filled: boolean }

interface Strip {
    scale: number;  // from SI to the shown unit
    label: string;
    least: number;  // smallest range, in the shown unit
    looks: [Look, Look];  // the second one is drawn over the first
}

export const trackStrip: Strip = {
    scale: 1e3, label: "x, mm", least: 0.1,
    looks: [
        { channel: 0, colour: "walker", dash: dashes.solid, filled: true },
        { channel: 1, colour: "base", dash: dashes.dotted, filled: true },
    ],
};
export const accelerationStrip: Strip = {
    scale: 1, label: "a, m/s²", least: 1,
    looks: [
        { channel: 1, colour: "measured", dash: dashes.solid, filled: true },
        { channel: 0, colour: "target", dash: dashes.dashed, filled: false },
    ],
};

function bands(strip: Strip, theme: Theme): uPlot.Band[] {
    return strip.looks.flatMap(({ filled, colour }, i) =>
        filled ? [{ series: [2 * i + 2, 2 * i + 1] as [number, number], fill: `${theme[colour]}88` }] : []);
}

export function makeLive(box: HTMLElement, stream: Rolling, strip: Strip, themes: Themes): { plot: Plot; draw: () => void } {
    const plot = new Plot(box, themes, (theme) => ({
        ...common,
        scales: { x: { time: false, range: [-window, 0] }, y: atLeast(strip.least) },
        axes: [xAxis(theme, "t, s before now"), yAxis(theme, strip.label)],
        series: [{}, ...strip.looks.flatMap(({ colour, dash }) => {
            const edge = line(theme[colour], dash, 1.5);
            return [edge, { ...edge }];
        })],
        bands: bands(strip, theme),
    }));
    let seen = -1;
    let data: Columns = [[], [], [], [], []];
    return {
        plot,
        draw: () => {
            if (seen === stream.version && !plot.stale) return;
            seen = stream.version;
            const found = stream.envelope(stream.newest, window, Math.max(50, Math.round(plot.pixels / 2)), strip.scale);
            data = [found[0]!, ...strip.looks.flatMap(({ channel }) => found.slice(2 * channel + 1, 2 * channel + 3))];
            plot.draw(data);
        },
    };
}
