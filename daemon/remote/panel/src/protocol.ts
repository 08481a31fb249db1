// What the daemon sends as text. Every number is SI; null where the daemon does not know it yet.

export type RunState =
    | "starting" | "idle" | "armed" | "identifying" | "ramping" | "settling" | "running" | "stopping" | "tripped";

export type Known = number | null;

export interface Estimate { value: Known; sigma: Known }

export interface Trip { cause: string; text: string; t_s: Known }

export interface Session {
    state: RunState;
    since_s: Known;  // how long it has been in this state
    rig: string;
    recording: string | null;
    record_next: boolean;  // the next run is recorded
    record_name: string | null;  // of that recording, without ending; null: by the time
    controller: string | null;
    you_control: boolean;
    trip: Trip | null;
    program: string;
    version: string;
}

export interface SetPoint { frequency_hz: Known; gamma_mps2: Known; rho: Known; phi_rad: Known }
export interface Drive extends SetPoint { locked: boolean }

export interface Harmonic {
    n: number;
    target_mps2: Known;
    measured_mps2: Known;
    phase_error_rad: Known;
    sigma_mps2: Known;
}

export interface Measured {
    gamma_mps2: Known;
    phi_rad: Known;
    harmonics: Harmonic[];
    rms_mps2: Known;
    volts_peak: Known;
}

/** `number`, `age_s`, `drive`: which measurement it is of; null before the first. */
export interface Result {
    number: Known;
    age_s: Known;  // since its end
    drive: SetPoint | null;
    current: boolean;  // measured at the set-point that is asked for now
    v_D_mps: Estimate | null;
    D_m: Estimate | null;
    efficiency: Estimate | null;
    mu: Estimate | null;
    stick: [number, number][];  // from and to, units of the period
    shortest_visible_stick: Known;  // of those that were not found
    periods: Known;
    steady: boolean;
}

/** `left_m`, `right_m`: x at the ends of the picture beside it, whichever is larger. */
export interface Walker { x_m: number; left_m: Known; right_m: Known }

export interface Point {
    gamma_mps2: number;
    phi_rad: number;
    v_D_mps: number;  // a point without one of these three is not drawn
    sigma_mps: Known;
    closed_form_mps: Known;
}

export interface Clock { name: string; ppm: Known; residual_s: Known }
export interface Loss { stream: string; got: number; lost: number }
export interface Disk { free_bytes: Known; backlog: Known }
/** counts[i] lie below bins_s[i]; a count more than bins lies above the last. */
export interface Jitter { bins_s: number[]; counts: number[]; worst_s: Known }

export interface State {
    session: Session;
    drive: Drive;
    measured: Measured;
    result: Result;
    walker: Walker | null;
    points: Point[];
    clocks: Clock[];
    losses: Loss[];
    disk: Disk;
    jitter: Jitter;
    limits: Record<string, unknown>;
}

export interface LogEvent { t_s: number; kind: string; text: string }

export type Message = { type: "state"; state: State } | { type: "event"; event: LogEvent };
