// The signs of the curves. They differ in colour and in shape, so that either is sufficient.
import type { Colour, Theme } from "../theme";

type Shape = (path: CanvasRenderingContext2D, x: number, y: number, r: number) => void;

const polygon = (angles: number[]): Shape => (path, x, y, r) => {
    angles.forEach((degrees, i) => {
        const a = (degrees * Math.PI) / 180;
        if (i === 0) path.moveTo(x + r * Math.cos(a), y - r * Math.sin(a));
        else path.lineTo(x + r * Math.cos(a), y - r * Math.sin(a));
    });
    path.closePath();
};

const shapes: Shape[] = [
    (path, x, y, r) => { path.moveTo(x + r, y); path.arc(x, y, r * 0.9, 0, 2 * Math.PI); },
    polygon([45, 135, 225, 315]),
    polygon([90, 210, 330]),
    polygon([0, 90, 180, 270]),
    polygon([270, 30, 150]),
    polygon([90, 162, 234, 306, 18]),
];
const cross: Shape = (path, x, y, r) => {
    for (const way of [1, -1]) {
        path.moveTo(x - 0.7 * r, y - 0.7 * way * r);
        path.lineTo(x + 0.7 * r, y + 0.7 * way * r);
    }
};
const colours: Colour[] = ["series-1", "series-2", "series-3", "series-4", "series-5", "series-6"];

export interface Sign { colour: string; shape: Shape }

/** One sign per colour; `null`: sign of points on no curve. */
export function sign(index: number | null, theme: Theme): Sign {
    if (index === null) return { colour: theme.faint, shape: cross };
    return { colour: theme[colours[index % colours.length]!], shape: shapes[index % shapes.length]! };
}

/** An error bar with caps of this half width. */
export function drawBar(ctx: CanvasRenderingContext2D, x: number, from: number, to: number, cap: number): void {
    ctx.beginPath();
    ctx.moveTo(x, from);
    ctx.lineTo(x, to);
    for (const y of [from, to]) {
        ctx.moveTo(x - cap, y);
        ctx.lineTo(x + cap, y);
    }
    ctx.stroke();
}

export function drawSign(ctx: CanvasRenderingContext2D, s: Sign, x: number, y: number, r: number): void {
    ctx.beginPath();
    s.shape(ctx, x, y, r);
    ctx.strokeStyle = s.colour;
    ctx.fillStyle = s.colour;
    ctx.fill();
    ctx.stroke();
}
