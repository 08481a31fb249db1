// The rows of the table of results, and the points of the figure.
import { unknown } from "./format";
import { degrees, paperG } from "./groups";
import type { Point, ResultRow, SetPoint } from "./protocol";

/** The newest first. Rows without a time are the oldest. */
export function newestFirst(rows: Iterable<ResultRow>): ResultRow[] {
    return [...rows].sort((a, b) => (b.time ?? "").localeCompare(a.time ?? "") || b.id - a.id);
}

export function setPointWords(asked: SetPoint | null): string {
    if (asked === null) return "";
    const { gamma_mps2, phi_rad, rho, frequency_hz } = asked;
    const words = (value: number | null): string => (value === null ? unknown : String(Number(value.toPrecision(5))).replace("-", "−"));
    const gamma = gamma_mps2 === null ? null : gamma_mps2 / paperG, phi = phi_rad === null ? null : degrees(phi_rad);
    return `γ ${words(gamma)} g, φ ${words(phi)}°, ρ ${words(rho)}, ${words(frequency_hz)} Hz`;
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
