// The last seconds as they come: where walker and base are, and the acceleration's envelope.
import type { Rolling } from "../rolling";
import { axis, common, dashes, line, Plot, type Columns } from "../plot";
import type { Theme, Themes } from "../theme";

interface Strip {
    window: number;  // s
    scale: number;   // from SI to what is shown
    label: string;
    names: [string, string];
    look: (theme: Theme) => [stroke: string, dash: number[]][];
}

export const trackStrip: Strip = {
    window: 20, scale: 1e3, label: "x, mm", names: ["walker", "base"],
    look: (theme) => [[theme.walker, dashes.solid], [theme.base, dashes.dotted]],
};
export const accelerationStrip: Strip = {
    window: 5, scale: 1, label: "a, m/s²", names: ["target", "measured"],
    look: (theme) => [[theme.target, dashes.dashed], [theme.measured, dashes.solid]],
};

export function makeLive(box: HTMLElement, stream: Rolling, strip: Strip, themes: Themes): { plot: Plot; draw: () => void } {
    const plot = new Plot(box, themes, (theme) => {
        const [first, second] = strip.look(theme);
        return {
            ...common,
            cursor: { show: false },
            scales: { x: { time: false, range: [-strip.window, 0] }, y: {} },
            axes: [axis(theme, "t, s before now"), axis(theme, strip.label, { size: 46 })],
            series: [
                {},
                line(strip.names[0], first![0], first![1], { width: 1.5 }),
                line(strip.names[1], second![0], second![1], { width: 1.5 }),
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
            data = stream.envelope(stream.newest, strip.window, Math.max(50, plot.pixels), strip.scale);
            plot.draw(data);
        },
    };
}
