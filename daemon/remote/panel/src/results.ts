// The rows of the table of results: their order, and the averages of repeats.
import { unknown } from "./format";
import { degrees, paperG } from "./groups";
import type { Estimate, Point, ResultRow, SetPoint } from "./protocol";

/** The newest first. Rows without a time are the oldest. */
export function newestFirst(rows: Iterable<ResultRow>): ResultRow[] {
    return [...rows].sort((a, b) => (b.time ?? "").localeCompare(a.time ?? "") || b.id - a.id);
}

/** Overtones are not in these words; rows that differ in them only are no repeats. */
export function setPointWords(asked: SetPoint | null): string {
    if (asked === null) return "";
    const { gamma_mps2, phi_rad, rho, frequency_hz } = asked;
    const words = (value: number | null): string => (value === null ? unknown : String(Number(value.toPrecision(5))).replace("-", "−"));
    const gamma = gamma_mps2 === null ? null : gamma_mps2 / paperG, phi = phi_rad === null ? null : degrees(phi_rad);
    return `γ ${words(gamma)} g, φ ${words(phi)}°, ρ ${words(rho)}, ${words(frequency_hz)} Hz`;
}

export interface Mean {
    mean: Estimate;  // sigma: standard error of the mean by the stated errors
    stated: number;  // error of one measurement, root mean square of the stated ones
    scatter: number | null;  // standard deviation of one measurement; null for a single one
}

/** The mean weighted by the stated errors; null when no row has a value with an error. */
export function weightedMean(values: readonly (Estimate | null)[]): Mean | null {
    const known = values.flatMap((e) => (e && e.value !== null && e.sigma !== null && e.sigma > 0 ? [{ x: e.value, s: e.sigma }] : []));
    if (!known.length) return null;
    const sum = (of: (e: { x: number; s: number }) => number): number => known.reduce((all, e) => all + of(e), 0);
    const weight = sum(({ s }) => s ** -2), mean = sum(({ x, s }) => x * s ** -2) / weight;
    const plain = sum(({ x }) => x) / known.length;
    return {
        mean: { value: mean, sigma: weight ** -0.5 },
        stated: Math.sqrt(sum(({ s }) => s ** 2) / known.length),
        scatter: known.length < 2 ? null : Math.sqrt(sum(({ x }) => (x - plain) ** 2) / (known.length - 1)),
    };
}

export interface Repeats {
    asked: SetPoint;
    count: number;  // of the measurements with a result
    v_D_mps: Mean;
    D_m: Mean | null;
    efficiency: Mean | null;
    newest: ResultRow;
}

/** Measurements of equal set-points as one line, in the order of their newest one. */
export function repeats(rows: Iterable<ResultRow>): Repeats[] {
    const groups = new Map<string, ResultRow[]>();
    for (const row of newestFirst(rows)) {
        if (row.asked === null || row.v_D_mps === null) continue;
        const key = JSON.stringify(row.asked);
        groups.set(key, [...(groups.get(key) ?? []), row]);
    }
    return [...groups.values()].flatMap((group) => {
        const v = weightedMean(group.map((row) => row.v_D_mps)), newest = group[0]!;
        if (v === null) return [];
        return [{
            asked: newest.asked!, count: group.length, v_D_mps: v, D_m: weightedMean(group.map((row) => row.D_m)),
            efficiency: weightedMean(group.map((row) => row.efficiency)), newest,
        }];
    });
}

/** The measured points with their set-points, and those of rows that the daemon measured before its start. */
export function pointsOf(measured: readonly Point[], rows: Iterable<ResultRow>): Point[] {
    const key = (v: number | null | undefined, gamma: number | null | undefined): string => `${v} ${gamma}`;
    const found = new Map<string, ResultRow>();
    for (const row of rows) if (row.v_D_mps?.value != null) found.set(key(row.v_D_mps.value, row.gamma_mps2?.value), row);
    const points = measured.map((point): Point => {
        const place = key(point.v_D_mps, point.gamma_mps2), asked = found.get(place)?.asked;
        found.delete(place);
        return asked ? { ...point, asked } : point;
    });
    for (const { asked, gamma_mps2, phi_rad, v_D_mps } of found.values()) {
        if (gamma_mps2?.value == null || phi_rad?.value == null || v_D_mps?.value == null) continue;
        points.push({
            gamma_mps2: gamma_mps2.value, phi_rad: phi_rad.value, v_D_mps: v_D_mps.value, sigma_mps: v_D_mps.sigma, closed_form_mps: null,
            ...(asked ? { asked } : {}),
        });
    }
    return points;
}
