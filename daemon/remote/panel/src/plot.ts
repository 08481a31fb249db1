// A uPlot in a box: it follows the box's width and the theme. Nothing is drawn but from draw().
import uPlot from "uplot";
import type { Theme, Themes } from "./theme";

export type Columns = (number | null)[][];
export type Options = Omit<uPlot.Options, "width" | "height">;

/** Dashes of lines, in CSS px: what a colour means, a dash says too. */
export const dashes = { solid: [] as number[], dashed: [7, 4], dotted: [2, 3] };

export class Plot {
    private plot: uPlot | null = null;
    private themeVersion = -1;
    private width = 0;
    private height = 0;

    constructor(
        readonly box: HTMLElement,
        private readonly themes: Themes,
        private readonly options: (theme: Theme) => Options,
    ) {
        new ResizeObserver(([entry]) => {
            this.width = Math.floor(entry!.contentRect.width);
            this.height = Math.floor(entry!.contentRect.height);
        }).observe(box);
    }

    /** CSS px across; 0 before it was laid out. */
    get pixels(): number { return this.width; }

    /** True when drawing is due though the data are the same. */
    get stale(): boolean {
        return this.themeVersion !== this.themes.version || this.plot?.width !== this.width ||
            this.plot.height !== this.room();
    }

    draw(data: Columns): void {
        if (this.width < 40) return;
        if (this.themeVersion !== this.themes.version) this.remake(data);
        const plot = this.plot!;
        if (plot.width !== this.width || plot.height !== this.room())
            plot.setSize({ width: this.width, height: this.room() });
        plot.setData(data as uPlot.AlignedData);
    }

    /** The legend is below the canvas, in the same box. */
    private room(): number {
        const legend = this.plot?.root.querySelector<HTMLElement>(".u-legend");
        return Math.max(60, this.height - (legend?.offsetHeight ?? 0));
    }

    private remake(data: Columns): void {
        this.plot?.destroy();
        this.themeVersion = this.themes.version;
        this.plot = new uPlot(
            { ...this.options(this.themes.current), width: this.width, height: this.height },
            data as uPlot.AlignedData, this.box,
        );
    }
}

export function axis(theme: Theme, label: string, more: uPlot.Axis = {}): uPlot.Axis {
    return {
        label,
        labelSize: 18,
        labelGap: 0,
        labelFont: "12px system-ui, sans-serif",
        font: "11px system-ui, sans-serif",
        stroke: theme.text,
        grid: { stroke: theme.grid, width: 1 },
        ticks: { stroke: theme.grid, width: 1, size: 4 },
        gap: 3,
        size: label.includes("/") ? 40 : 26,
        ...more,
    };
}

export function line(label: string, stroke: string, dash: number[], more: uPlot.Series = {}): uPlot.Series {
    return { label, stroke, width: 2, dash, points: { show: false }, ...more };
}

/** What all plots have in common: no zoom by dragging, which would hide data from an operator unasked. */
export const common: Pick<Options, "cursor" | "legend"> = {
    cursor: { drag: { x: false, y: false }, points: { size: 6 } },
    legend: { live: false, markers: { dash: (u, i) => legendDash(u.series[i]!.dash ?? []) } },
};

function legendDash(dash: number[]): string {
    if (dash.length === 0) return "solid";
    return dash[0]! > 3 ? "dashed" : "dotted";
}
