// Harmonics of the base as bars in dB of gamma, with their targets and the errors of phase; in numbers below.
import type uPlot from "uplot";
import { byId, setRows } from "../dom";
import { decibels, fixed, number, unknown, withError } from "../format";
import { common, Plot, xAxis, yAxis, type Columns } from "../plot";
import type { Harmonic, Known } from "../protocol";
import type { Store } from "../store";
import type { Theme, Themes } from "../theme";

const floor = -100;  // dB, lower end of the bars
const clamp = (level: number | null): number | null => (level === null ? null : Math.max(floor, level));

function milliradians(phase: Known): string { return phase === null ? unknown : `${fixed(phase * 1e3, 1)} mrad`; }

/** Bars, a mark of the target across each, the phase's error above it. */
function drawBars(u: uPlot, harmonics: Harmonic[], theme: Theme): void {
    const { ctx } = u, ratio = devicePixelRatio;
    const [n, levels, targets] = u.data;
    ctx.save();
    ctx.font = `${11 * ratio}px system-ui, sans-serif`;
    ctx.textAlign = "center";
    const half = Math.min(14 * ratio, (u.bbox.width / Math.max(1, n.length)) * 0.3);
    const bottom = u.valToPos(floor, "y", true);
    n.forEach((harmonic, i) => {
        const x = u.valToPos(harmonic, "x", true);
        const level = levels?.[i], target = targets?.[i], phase = harmonics[i]?.phase_error_rad ?? null;
        let top = bottom;
        if (typeof level === "number") {
            top = u.valToPos(level, "y", true);
            ctx.fillStyle = theme.measured;
            ctx.fillRect(x - half, top, 2 * half, bottom - top);
        }
        if (typeof target === "number") {
            const y = u.valToPos(target, "y", true);
            ctx.strokeStyle = theme.target;
            ctx.lineWidth = 3 * ratio;
            ctx.setLineDash([5 * ratio, 3 * ratio]);
            ctx.beginPath();
            ctx.moveTo(x - 1.6 * half, y);
            ctx.lineTo(x + 1.6 * half, y);
            ctx.stroke();
            top = Math.min(top, y);
        }
        if (typeof target === "number" && phase !== null) {
            ctx.fillStyle = theme.text;
            ctx.fillText(fixed(phase * 1e3, 1), x, top - 6 * ratio);
        }
    });
    ctx.restore();
}

/** Error as a share of the target; without a target, level relative to gamma. */
function errorWords(h: Harmonic, gamma: Known): string {
    if (h.measured_mps2 === null) return unknown;
    if (h.target_mps2) return `${fixed((h.measured_mps2 / h.target_mps2 - 1) * 100, 2)} %`;
    const level = decibels(h.measured_mps2, gamma);
    return level === null ? unknown : level === -Infinity ? "0" : `${fixed(level, 1)} dB`;
}

function cells(h: Harmonic, gamma: Known): string[] {
    return [
        String(h.n), number(h.target_mps2), withError({ value: h.measured_mps2, sigma: h.sigma_mps2 }),
        errorWords(h, gamma), h.target_mps2 ? milliradians(h.phase_error_rad) : unknown,
    ];
}

export function makeHarmonics(box: HTMLElement, store: Store, themes: Themes): () => void {
    const body = byId("harmonics-rows", HTMLTableSectionElement);
    let harmonics: Harmonic[] = [];
    const plot = new Plot(box, themes, (theme) => ({
        ...common,
        scales: { x: { time: false, range: (_u, _low, high) => [0.4, (high ?? 8) + 0.6] }, y: { range: [floor, 20] } },
        axes: [
            xAxis(theme, "n f", { grid: { show: false }, incrs: [1], space: 10 }),
            yAxis(theme, "dB of γ", { incrs: [20, 40], space: 18 }),
        ],
        series: [{}, { paths: () => null, points: { show: false } }, { paths: () => null, points: { show: false } }],
        hooks: { draw: [(u) => drawBars(u, harmonics, theme)] },
    }));
    let seen = -1;
    let data: Columns = [[], [], []];
    return () => {
        const { state } = store;
        if (!state || (seen === store.stateVersion && !plot.stale)) return;
        seen = store.stateVersion;
        const gamma = state.drive.gamma_mps2 || state.measured.gamma_mps2;
        harmonics = state.measured.harmonics.slice(0, 16);
        data = [
            harmonics.map((h) => h.n),
            harmonics.map((h) => clamp(decibels(h.measured_mps2, gamma))),
            harmonics.map((h) => (h.target_mps2 ? clamp(decibels(h.target_mps2, gamma)) : null)),
        ];
        plot.draw(data);
        setRows(body, harmonics.map((h) => cells(h, gamma)));
    };
}
