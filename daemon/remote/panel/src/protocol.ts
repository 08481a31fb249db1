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
    controller: string | null;
    you_control: boolean;
    trip: Trip | null;
    program: string;
    version: string;
}

export interface Drive { frequency_hz: Known; gamma_mps2: Known; rho: Known; phi_rad: Known; locked: boolean }

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

export interface Result {
    v_D_mps: Estimate | null;
    D_m: Estimate | null;
    efficiency: Estimate | null;
    mu: Estimate | null;
    periods: Known;
    steady: boolean;
}

export interface Walker { x_m: number; low_m: number; high_m: number }

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
