// a_B over two periods: target and measurement.
import { channel, type SampleFrame } from "../frames";
import { atLeast, common, dashes, line, Plot, xAxis, yAxis, type Columns } from "../plot";
import type { Store } from "../store";
import type { Themes } from "../theme";

export function makeWaveform(box: HTMLElement, store: Store, themes: Themes): { plot: Plot; draw: () => void } {
    const plot = new Plot(box, themes, (theme) => ({
        ...common,
        scales: { x: { time: false }, y: atLeast(1) },
        axes: [xAxis(theme, "t, ms"), yAxis(theme, "a, m/s²")],
        series: [
            {},
            line(theme.measured, dashes.solid, 3),
            line(theme.target, dashes.dashed),  // drawn last: where both agree, the measurement shows through the gaps
        ],
    }));
    let seen: SampleFrame | null = null;
    let data: Columns = [[], [], []];
    return {
        plot,
        draw: () => {
            if (seen === store.waveform && !plot.stale) return;
            const frame = (seen = store.waveform);
            if (frame)
                data = [
                    Array.from({ length: frame.count }, (_, i) => i * frame.dt * 1e3),
                    channel(frame, 1, 1), channel(frame, 0, 1),
                ];
            plot.draw(data);
        },
    };
}
