// A uPlot in a box. It follows the box's width and the theme, and draws only in draw().
import uPlot from "uplot";
import { tickTexts } from "./format";
import type { Theme, Themes } from "./theme";

export type Columns = (number | null)[][];
export type Options = Omit<uPlot.Options, "width" | "height">;

/** Dashes of lines, in CSS px. Lines differ by dash as well as by colour. */
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

    /** Width in CSS px; 0 before the layout. */
    get pixels(): number { return this.width; }

    /** True when the plot must be drawn again although the data are the same. */
    get stale(): boolean {
        return this.themeVersion !== this.themes.version || this.plot?.width !== this.width ||
            this.plot.height !== this.height;
    }

    draw(data: Columns): void {
        if (this.width < 40 || this.height < 40) return;
        if (this.themeVersion !== this.themes.version) this.remake(data);
        const plot = this.plot!;
        if (plot.width !== this.width || plot.height !== this.height)
            plot.setSize({ width: this.width, height: this.height });
        plot.setData(data as uPlot.AlignedData);
    }

    /** The plot as a picture on its ground; null before it was drawn. */
    async png(ground: string): Promise<Blob | null> {
        const drawn = this.plot?.ctx.canvas;
        if (!drawn) return null;
        const canvas = new OffscreenCanvas(drawn.width, drawn.height), ctx = canvas.getContext("2d")!;
        ctx.fillStyle = ground;
        ctx.fillRect(0, 0, canvas.width, canvas.height);
        ctx.drawImage(drawn, 0, 0);
        return canvas.convertToBlob();
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

function axis(theme: Theme, label: string, size: number, more: uPlot.Axis): uPlot.Axis {
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
        size,
        values: (_u, splits) => tickTexts(splits),
        ...more,
    };
}

/** A range of at least `size`, so that noise of a silent signal is not magnified. */
export function atLeast(size: number): uPlot.Scale {
    return { range: { min: { pad: 0.1, soft: -size, mode: 2 }, max: { pad: 0.1, soft: size, mode: 2 } } };
}

export const xAxis = (theme: Theme, label: string, more: uPlot.Axis = {}): uPlot.Axis => axis(theme, label, 26, more);
export const yAxis = (theme: Theme, label: string, more: uPlot.Axis = {}): uPlot.Axis => axis(theme, label, 46, more);

export function line(stroke: string, dash: number[], width = 2): uPlot.Series {
    return { stroke, width, dash, points: { show: false } };
}

/** No zoom by dragging, because it could hide data by accident. The page itself has the keys of the lines. */
export const common: Pick<Options, "cursor" | "legend"> = { cursor: { show: false }, legend: { show: false } };
