// What a run will take, before it starts: time, way of the walker, bytes.
import { duration, fixed, prefixed } from "../format";
import type { State } from "../protocol";

/** measurements: null: until stopped. */
export interface Asked { periods: number | null; measurements: number | null }

/** `trouble`: the walker does not stay inside the edge limit. */
export interface Outlook { text: string; trouble: boolean }

export function outlookOf(state: Pick<State, "outlook" | "drive" | "session">, asked: Asked): Outlook {
    const { outlook, drive, session } = state, f = drive.frequency_hz;
    if (f === null || asked.periods === null) return { text: "", trouble: false };
    const measured = asked.periods * (asked.measurements ?? 1), before = outlook.before_periods / f;
    const all = before + measured / f;
    const parts: string[] = [];
    if (asked.measurements === null) parts.push(`First result after about ${duration(all)}, then on until stopped.`);
    else parts.push(`About ${duration(all)}, of which ${duration(measured / f)} are measured.`);
    const way = wayWords(state, measured, asked.measurements === null);
    parts.push(way.text);
    const size = session.record_next ? outlook.recorded[session.frames ?? ""] : undefined;
    if (size && asked.measurements === null) parts.push(`Recorded: ${prefixed(60 * size.bytes_per_s, "B")} a minute.`);
    else if (size) parts.push(`Recorded: about ${prefixed(all * size.bytes_per_s + size.first_bytes, "B")}.`);
    return { text: parts.filter((part) => part !== "").join(" "), trouble: way.trouble };
}

function wayWords({ outlook, drive }: Pick<State, "outlook" | "drive">, measured: number, open: boolean): Outlook {
    const f = drive.frequency_hz!, v = outlook.walk_mps?.value ?? null;
    if (v === null) return { text: "How far the walker goes is not known yet. Give μ, and it is predicted.", trouble: false };
    if (outlook.way_m === null || v === 0) return { text: "", trouble: false };
    const fits = (outlook.way_m / Math.abs(v)) * f - outlook.walking_periods;
    const until = `the edge limit, ${fixed(1e3 * outlook.way_m, 1)} mm away`;
    if (open) return { text: `The walker reaches ${until}, after about ${Math.max(0, Math.floor(fits))} measured periods.`, trouble: fits < measured };
    if (fits >= measured) {
        const goes = (Math.abs(v) * (outlook.walking_periods + measured)) / f;
        return { text: `The walker goes about ${fixed(1e3 * goes, 1)} mm; the edge limit is ${fixed(1e3 * outlook.way_m, 1)} mm away.`, trouble: false };
    }
    const how = fits < 1 ? "before the first measured period" : `after about ${Math.floor(fits)} of ${measured} periods`;
    return { text: `⚠ It does not fit: the walker reaches ${until}, ${how}.`, trouble: true };
}
