// The last seconds as they come: where walker and base are, and the acceleration's envelope.
import type { Rolling } from "../rolling";
import { common, dashes, line, Plot, xAxis, yAxis, type Columns } from "../plot";
import type { Theme, Themes } from "../theme";

type Look = [stroke: string, dash: number[]];

interface Strip {
    window: number;  // s
    scale: number;   // from SI to what is shown
    label: string;
    first: number;  // channel that is drawn first, below the other
    look: (theme: Theme) => [Look, Look];
}

export const trackStrip: Strip = {
    window: 20, scale: 1e3, label: "x, mm", first: 0,
    look: (theme) => [[theme.walker, dashes.solid], [theme.base, dashes.dotted]],
};
export const accelerationStrip: Strip = {
    window: 5, scale: 1, label: "a, m/s²", first: 1,
    look: (theme) => [[theme.measured, dashes.solid], [theme.target, dashes.dashed]],
};

export function makeLive(box: HTMLElement, stream: Rolling, strip: Strip, themes: Themes): { plot: Plot; draw: () => void } {
    const plot = new Plot(box, themes, (theme) => {
        const [first, second] = strip.look(theme);
        return {
            ...common,
            scales: { x: { time: false, range: [-strip.window, 0] }, y: {} },
            axes: [xAxis(theme, "t, s before now"), yAxis(theme, strip.label)],
            series: [
                {},
                line(first[0], first[1], 1.5),
                line(second[0], second[1], 1.5),
            ],
        };
    });
    let seen = -1;
    let data: Columns = [[], [], []];
    return {
        plot,
        draw: () => {
            if (seen === stream.version && !plot.stale) return;
            seen = stream.version;
            const [time, ...channels] = stream.envelope(stream.newest, strip.window, Math.max(50, plot.pixels), strip.scale);
            data = [time!, channels[strip.first]!, channels[1 - strip.first]!];
            plot.draw(data);
        },
    };
}
