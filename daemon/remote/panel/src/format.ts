// Text of numbers for the operator. The minus sign is U+2212, as wide as the plus.
import type { Estimate, Known } from "./protocol";

export const unknown = "–";

function known(value: Known | undefined): value is number {
    return typeof value === "number" && Number.isFinite(value);
}

export function fixed(value: number, decimals: number): string {
    const text = value.toFixed(decimals);
    return Number(text) === 0 ? text.replace("-", "") : text.replace("-", "−");
}

/** Decimals that show `digits` digits of a number of this size after rounding: 0.0996 needs 2 decimals for 2 digits. */
export function decimalsFor(size: number, digits: number): number {
    if (!(size > 0)) return 0;
    const exponent = Number(size.toExponential(digits - 1).split("e")[1]);
    return Math.min(12, Math.max(0, digits - 1 - exponent));
}

/** `digits` significant digits, without an exponent. */
export function number(value: Known | undefined, digits = 4): string {
    return known(value) ? fixed(value, decimalsFor(Math.abs(value), digits)) : unknown;
}

/** "14.582 ± 0.099": sigma with two digits, the value with the same decimals. Without a sigma four digits. */
export function withError(estimate: Estimate | null | undefined, scale = 1): string {
    if (!estimate || !known(estimate.value)) return unknown;
    const value = estimate.value * scale;
    if (!known(estimate.sigma)) return number(value);
    const sigma = Math.abs(estimate.sigma * scale);
    if (sigma === 0) return `${number(value)} ± 0`;
    const decimals = decimalsFor(sigma, 2);
    return `${fixed(value, decimals)} ± ${fixed(sigma, decimals)}`;
}

/** "14.582 ± 0.099 ± 0.015 syst": as withError(), and the part by the calibrations where it is known. */
export function withErrors(estimate: Estimate | null | undefined, scale = 1): string {
    const text = withError(estimate, scale), systematic = estimate?.systematic;
    if (!known(systematic)) return text;
    const error = Math.abs(systematic * scale);
    return `${text} ± ${fixed(error, decimalsFor(error, 2))} syst`;
}

/** Texts of an axis's ticks with the decimals that their step needs: 1.0002, 1.0004 instead of 1, 1. */
export function tickTexts(splits: readonly Known[]): string[] {
    const values = splits.filter(known);
    let step = Infinity;
    for (let i = 1; i < values.length; i++) {
        const apart = Math.abs(values[i]! - values[i - 1]!);
        if (apart > 0) step = Math.min(step, apart);
    }
    if (step === Infinity) return splits.map((value) => number(value));
    let decimals = 0;
    while (decimals < 12 && Math.abs(Number(step.toFixed(decimals)) - step) > 1e-3 * step) decimals++;
    return splits.map((value) => (known(value) ? fixed(value, decimals) : ""));
}

const prefixes: [number, string][] = [[1e9, "G"], [1e6, "M"], [1e3, "k"], [1, ""], [1e-3, "m"], [1e-6, "µ"], [1e-9, "n"]];

/** The value with an SI prefix, one to three digits before the point: "3.20 µs", "112 GB". */
export function prefixed(value: Known | undefined, unit: string, digits = 3): string {
    if (!known(value)) return unknown;
    if (Math.abs(value) < 1e-12) return `0 ${unit}`;  // below the resolution of all values on the page
    const rounded = Math.abs(Number(value.toPrecision(digits)));
    const [factor, prefix] = prefixes.find(([size]) => rounded >= size) ?? [1e-9, "n"];
    return `${number(value / factor, digits)} ${prefix}${unit}`;
}

/** "4.2 s", "3 min 07 s", "2 h 05 min". */
export function duration(seconds: Known | undefined): string {
    if (!known(seconds)) return unknown;
    if (seconds < 60) return `${fixed(seconds, 1)} s`;
    const whole = Math.floor(seconds);
    const two = (n: number): string => String(n).padStart(2, "0");
    if (whole < 3600) return `${Math.floor(whole / 60)} min ${two(whole % 60)} s`;
    return `${Math.floor(whole / 3600)} h ${two(Math.floor(whole / 60) % 60)} min`;
}

/** Clock time of this computer, `seconds` ago: "17:03:21". */
export function clockTime(seconds: number): string { return clockTimeAt(Date.now() - 1e3 * seconds); }
export function clockTimeAt(ms: number): string { return new Date(ms).toLocaleTimeString("en-GB"); }

/** Level of an amplitude relative to a reference, dB. */
export function decibels(amplitude: Known | undefined, reference: Known | undefined): number | null {
    if (!known(amplitude) || !known(reference) || reference <= 0 || amplitude < 0) return null;
    return amplitude === 0 ? -Infinity : 20 * Math.log10(amplitude / reference);
}
