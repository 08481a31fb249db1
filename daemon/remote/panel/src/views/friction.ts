// Friction of the newest measurement against the velocity of slip, with errors: free of any law.
import type uPlot from "uplot";
import { common, Plot, xAxis, yAxis, type Columns } from "../plot";
import type { Result } from "../protocol";
import type { Store } from "../store";
import type { Theme, Themes } from "../theme";
import { drawBar, drawSign, sign } from "./symbols";

const millimetre = 1e-3;
const leastHeight = 0.01;  // of mu

function drawErrors(u: uPlot, friction: Result["friction"], theme: Theme): void {
    const { ctx } = u, ratio = devicePixelRatio, look = sign(0, theme);
    ctx.save();
    ctx.strokeStyle = look.colour;
    ctx.lineWidth = 1.5 * ratio;
    for (const [v, mu, sigma] of friction) {
        const x = u.valToPos(v / millimetre, "x", true);
        drawBar(ctx, x, u.valToPos(mu - sigma, "y", true), u.valToPos(mu + sigma, "y", true), 3 * ratio);
        drawSign(ctx, look, x, u.valToPos(mu, "y", true), 4 * ratio);
    }
    ctx.restore();
}

/** All values with their errors. */
function range(friction: Result["friction"]): [number, number] {
    if (!friction.length) return [0, 0.2];
    const low = Math.min(...friction.map(([, mu, sigma]) => mu - sigma)), high = Math.max(...friction.map(([, mu, sigma]) => mu + sigma));
    const room = Math.max(0.1 * (high - low), (leastHeight - high + low) / 2);
    return [low - room, high + room];
}

export function makeFriction(box: HTMLElement, store: Store, themes: Themes): () => void {
    let friction: Result["friction"] = [];
    const plot = new Plot(box, themes, (theme) => ({
        ...common,
        scales: { x: { time: false, range: (_u, low, high) => [1.1 * Math.min(low ?? 0, -1), 1.1 * Math.max(high ?? 0, 1)] }, y: { range: () => range(friction) } },
        axes: [xAxis(theme, "v − v_B in slip, mm/s"), yAxis(theme, "friction μ")],
        series: [{}, { paths: () => null, points: { show: false } }],
        hooks: { draw: [(u) => drawErrors(u, friction, theme)] },
    }));
    let seen = -1;
    return () => {
        const { state } = store;
        if (!state || (seen === store.stateVersion && !plot.stale)) return;
        seen = store.stateVersion;
        friction = state.result.friction;
        const columns: Columns = [friction.map(([v]) => v / millimetre), friction.map(([, mu]) => mu)];
        plot.draw(columns);
    };
}
