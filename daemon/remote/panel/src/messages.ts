// Converts text messages of the daemon to the types of protocol.ts. Missing values are shown as "not known".
import {
    driving, type Drive, type Jitter, type LogEvent, type Measured, type Message, type Outlook, type Result, type RunState, type Session, type State, type Switches,
    type Tracking,
} from "./protocol";

export const maxPoints = 2000;

const session: Session = {
    state: "idle", since_s: null, rig: "", recording: null, finishing: false, record_next: false, frames: null, record_name: null, controller: null, you_control: false,
    trip: null, simulated: false, to_middle: false, may_clear: true, program: "shakerd", version: "", daemon: "",
};
const drive: Drive = { frequency_hz: null, gamma_mps2: null, rho: null, phi_rad: null, locked: false };
const measured: Measured = { gamma_mps2: null, phi_rad: null, harmonics: [], rms_mps2: null, volts_peak: null };
const result: Result = {
    number: null, age_s: null, drive: null, current: true, v_D_mps: null, D_m: null, efficiency: null, bench_check: null, bench_alarm: false, mu: null, mu_refused: "", friction: [], stick: [], shortest_visible_stick: null, periods: null, steady: false,
};
const outlook: Outlook = { before_periods: 0, walking_periods: 0, walk_mps: null, walk_from: null, way_m: null, recorded: {} };
const jitter: Jitter = { bins_s: [], counts: [], worst_s: null };

function object(value: unknown): Record<string, unknown> {
    return typeof value === "object" && value !== null && !Array.isArray(value)
        ? (value as Record<string, unknown>)
        : {};
}

/** A complete section; null and missing members get the value of `otherwise`. */
function section<T extends object>(value: unknown, otherwise: T): T {
    const given = Object.entries(object(value)).filter(([, member]) => member !== null);
    return { ...otherwise, ...Object.fromEntries(given) };
}

function list<T>(value: unknown): T[] {
    return Array.isArray(value) ? (value as T[]) : [];
}

/** At rest the measured motion is noise and none of its figures is shown. */
function measuredOf(now: Measured, state: RunState): Measured {
    if (driving.has(state)) return now;
    const harmonics = now.harmonics.map((h) => ({ ...h, measured_mps2: null, phase_error_rad: null, sigma_mps2: null }));
    return { ...measured, harmonics };
}

function stateOf(raw: Record<string, unknown>): State {
    return {
        session: section(raw["session"], session),
        drive: section(raw["drive"], drive),
        measured: measuredOf(section(raw["measured"], measured), section(raw["session"], session).state),
        result: section(raw["result"], result),
        walker: (raw["walker"] ?? null) as State["walker"],
        points: list<State["points"][number]>(raw["points"]).slice(-maxPoints),
        outlook: section(raw["outlook"], outlook),
        progress: (raw["progress"] ?? null) as State["progress"],
        gauges: list(raw["gauges"]),
        campaign: (raw["campaign"] ?? null) as State["campaign"],
        plan_check: (raw["plan_check"] ?? null) as State["plan_check"],
        plans: list(raw["plans"]),
        cameras: list(raw["cameras"]),
        clocks: list(raw["clocks"]),
        losses: list(raw["losses"]),
        disk: section(raw["disk"], { free_bytes: null, room_bytes: null, backlog: null }),
        tracking: section<Tracking>(raw["tracking"], { median_s: null, slowest_s: null, core_share: null }),
        jitter: section(raw["jitter"], jitter),
        real_time: list(raw["real_time"]),
        switches: section<Switches>(raw["switches"], { abort_contact: null, enable_output: null }),
        limits: object(raw["limits"]),
    };
}

function eventOf(raw: Record<string, unknown>): LogEvent {
    const age = Number(raw["age_s"] ?? NaN);
    return { id: Number(raw["id"]), t_s: Number(raw["t_s"]), at: Date.now() - 1e3 * age, kind: String(raw["kind"] ?? ""), text: String(raw["text"] ?? "") };
}

function parsed(text: string): unknown {
    try {
        return JSON.parse(text);
    } catch {
        return null;
    }
}

/** Sections missing in a state keep their values of `before`; the points are not sent ten times a second. */
function kept(raw: Record<string, unknown>, before: State | null): Partial<State> {
    return Object.fromEntries(Object.entries(before ?? {}).filter(([name]) => !(name in raw)));
}

/** Null for an unknown message. */
export function parseMessage(text: string, before: State | null = null): Message | null {
    const raw = object(parsed(text));
    if (raw["type"] === "state") return { type: "state", state: { ...stateOf(raw), ...kept(raw, before) } };
    if (raw["type"] === "event") return { type: "event", event: eventOf(raw) };
    if (raw["type"] === "results") return { type: "results", results: list(raw["results"]) };
    return null;
}
