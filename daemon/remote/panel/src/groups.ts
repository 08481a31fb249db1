// The measured points as curves. The points of a curve have the same value of the other parameter.
import { fixed } from "./format";
import type { Point, SetPoint } from "./protocol";

export const paperG = 9.8;  // m/s^2

export interface PlottedPoint { x: number; v: number; sigma: number | null; closed: number | null; asked: SetPoint | null }  // mm/s
/** `single`: points that are on no curve. */
export interface Curve { label: string; single: boolean; points: PlottedPoint[] }

export const maxCurves = 6;
const leastPoints = 3;

interface Axis { x(p: Point): number; same(p: Point): number; label(value: number): string; leastSpan: number }

/** Degrees in (−180, 180], so that neighbours in a sweep through zero stay neighbours. */
export function degrees(radians: number): number {
    const turn = ((radians * 180) / Math.PI) % 360;
    return turn > 180 ? turn - 360 : turn <= -180 ? turn + 360 : turn;
}

export const axes: Record<"gamma" | "phi", Axis> = {
    gamma: {
        x: (p) => p.gamma_mps2 / paperG,
        same: (p) => degrees((Math.round(degrees(p.phi_rad)) * Math.PI) / 180),
        label: (value) => `φ = ${fixed(value, 0)}°`,
        leastSpan: 1,
    },
    phi: {
        x: (p) => degrees(p.phi_rad),
        same: (p) => Math.round((p.gamma_mps2 / paperG) * 100) / 100,
        label: (value) => `γ = ${fixed(value, 2)} g`,
        leastSpan: 90,
    },
};

const inMillimetres = (metres: number | null): number | null => (metres === null ? null : metres * 1e3);

/**
 * At least three points with the same other parameter make a curve. If there are more than maxCurves, the longest ones
 * remain. Curves are in the order of their parameter, points in the order of x. All other points are one last curve.
 */
export function curves(points: readonly Point[], axis: Axis): Curve[] {
    const found = new Map<number, PlottedPoint[]>();
    for (const p of points) {
        if (![p.gamma_mps2, p.phi_rad, p.v_D_mps].every(Number.isFinite)) continue;
        const key = axis.same(p);
        const list = found.get(key) ?? [];
        found.set(key, list);
        list.push({
            x: axis.x(p),
            v: p.v_D_mps * 1e3,
            sigma: inMillimetres(p.sigma_mps),
            closed: inMillimetres(p.closed_form_mps),
            asked: p.asked ?? null,
        });
    }
    const groups = [...found.entries()].sort(([a, p], [b, q]) => q.length - p.length || a - b);
    const drawn = groups.filter(([, list], i) => list.length >= leastPoints && i < maxCurves);
    const rest = groups.filter((group) => !drawn.includes(group)).flatMap(([, list]) => list);
    const inOrder = (list: PlottedPoint[]): PlottedPoint[] => list.sort((a, b) => a.x - b.x);
    const result = drawn
        .sort(([a], [b]) => a - b)
        .map(([key, list]) => ({ label: axis.label(key), single: false, points: inOrder(list) }));
    if (rest.length) result.push({ label: "others", single: true, points: inOrder(rest) });
    return result;
}
