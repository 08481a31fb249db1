// Text messages of the daemon. All numbers are in SI units; null: not known yet.

export type RunState =
    | "starting" | "idle" | "armed" | "identifying" | "checking" | "ramping" | "settling" | "running" | "stopping" | "tripped" | "finishing";

/** States in which the drive may be on. In all others the measured motion of the base is noise. */
export const driving: ReadonlySet<RunState> = new Set<RunState>(["identifying", "checking", "ramping", "settling", "running", "stopping"]);

export type Known = number | null;

/** systematic: part of the standard error that the calibrations cause; without a calibration it is missing. */
export interface Estimate { value: Known; sigma: Known; systematic?: Known }

/** `finding`: what happened, with value and limit in the operator's units. `advice`: what to do. SI: `value`, `limit`. */
export interface Trip {
    cause: string;
    finding: string;
    advice: string;
    value: Known;
    limit: Known;
    t_s: Known;
    age_s: Known;  // since the trip
    recording: string | null;  // that has the stop; null: not complete yet
    pictures?: number;  // of the moment, one a camera
}

export interface Session {
    state: RunState;
    since_s: Known;  // time in this state
    rig: string;
    recording: string | null;
    finishing: boolean;  // the run is over, and its recording is being completed
    record_next: boolean;  // the next run is recorded
    frames: string | null;  // pictures of the next recording
    record_name: string | null;  // of the next recording, without ending; null: named by its time
    controller: string | null;
    you_control: boolean;
    trip: Trip | null;
    simulated: boolean;  // the walker may be put back by an order
    to_middle: boolean;  // the walker is being brought to the middle
    may_clear: boolean;  // the drive is silent and the end of the stopped run is recorded
    program: string;
    version: string;
    daemon: string;  // identity of the process, another one after each start
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

/** `number`, `age_s`, `drive` describe the measurement; null before the first. */
export interface Result {
    number: Known;
    age_s: Known;  // since its end
    drive: SetPoint | null;
    current: boolean;  // measured at the present set-point
    v_D_mps: Estimate | null;
    D_m: Estimate | null;
    efficiency: Estimate | null;
    bench_check: Estimate | null;  // acceleration of the base by the cameras over that by the accelerometer
    bench_alarm: boolean;  // they disagree
    mu: Estimate | null;
    mu_refused: string;  // why Coulomb's law, of which it is a parameter, does not describe the measurements; "": it does
    friction: [number, number, number][];  // v_R in m/s, mu at it and its error, of the newest measurement
    stick: [number, number][];  // from and to, units of the period
    shortest_visible_stick: Known;  // shortest interval that would have been detected, units of the period
    periods: Known;
    steady: boolean;
}

/** Bytes of a recording. first_bytes: of the pictures of the first second. */
export interface RecordedSize { bytes_per_s: number; first_bytes: number }

/** Before a run at the set-point; periods of the drive. way_m: to the edge limit in the direction of the walk. */
export interface Outlook {
    before_periods: number;  // until the first measurement
    walking_periods: number;  // of a walker on its way, besides those that are measured
    walk_mps: Estimate | null;
    walk_from: string | null;
    way_m: Known;
    recorded: Record<string, RecordedSize>;  // by the kinds of pictures for which the cameras are open
}

/** Progress of the run under way. */
export interface Progress {
    measurement: number;  // under way, or the next one; from 1
    measurements: number;  // asked for; 0: until stopped
    periods_done: Known;
    left_s: Known;
    waits_for: string | null;
    walk_mps: Known;
    periods_left: Known;  // until the edge limit
}

/** The campaign under way, or the last one. */
export interface Campaign {
    name: string;
    title: string;
    folder: string;  // beside the recordings
    active: boolean;  // it has the bench
    paused: boolean;
    doing: string;  // "measuring", "returning", "changing", "paused", "ended", "interrupted" (before this daemon)
    point: string;  // in progress or next, in words
    points: number;
    ended: number;
    left_s: Known;
    newest: string;  // event in words
    known_mu: string;
}

/** The newest check of a plan; misfits: points that do not fit, with reasons, the first ones. */
export interface PlanCheck { plan: string; under_way: boolean; points: number; fit: number; summary: string; misfits: string[] }

/** Largest value of a quantity in a period, in the unit of its limit. */
export interface Gauge { quantity: string; unit: string; limit: Known; set_point: Known; live: Known }

/**
 * `left_m`, `right_m`: x at the left and right end of the picture; left_m may be the larger one. `edge_m`: distance of
 * its outline from the nearer end.
 */
export interface Walker { x_m: number; left_m: Known; right_m: Known; edge_m: Known }

export interface Point {
    gamma_mps2: number;
    phi_rad: number;
    v_D_mps: number;  // points without one of these three values are not drawn
    sigma_mps: Known;
    closed_form_mps: Known;
    asked?: SetPoint;  // known from the table of results
}

/**
 * `width_px`: of the whole picture, of which the page shows a smaller copy. `along`: direction of +x in the picture.
 * `clipped`: share of pixels at the end of the sensor's range. `edge_px`: width of the steepest edges; 2 px when sharp.
 * `region_px`: where the target is searched first. `proposed_px`: that region moved with the target; null: it is lost.
 * `not_found`: why the targets were not found since the start; null: they are followed.
 * `origin_px`: of a cropped picture in the whole one, which the rig file means.
 */
export interface Camera {
    name: string;
    width_px: Known;
    height_px: Known;
    origin_px: [number, number];
    mm_per_px: Known;
    along: [number, number];
    exposure_s: Known;
    clipped: Known;
    edge_px: Known;
    not_found: string | null;
    targets: { name: string; region_px: Region; proposed_px: Region | null }[];
}
/** x, y, width, height in px. */
export type Region = [number, number, number, number];

export interface Clock { name: string; ppm: Known; residual_s: Known }
export interface Loss { stream: string; got: number; lost: number }
/** `room_bytes`: for recordings; the others must stay free. */
export interface Disk { free_bytes: Known; room_bytes: Known; backlog: Known }
/** Time that a picture takes: half of them, 99.9 % of them are faster; share of a processor for all cameras. */
export interface Tracking { median_s: Known; slowest_s: Known; core_share: Known }
/** counts[i]: number of values up to bins_s[i] and above bins_s[i - 1]; the last count is for larger values. */
export interface Jitter { bins_s: number[]; counts: number[]; worst_s: Known }

/** A request for real time to the operating system; refused: reason, null if granted. */
export interface RealTimeGrant { what: string; refused: string | null }

/** Null: the rig has none. */
export interface Switches { abort_contact: "closed" | "open" | "unreadable" | null; enable_output: boolean | null }

export interface State {
    session: Session;
    drive: Drive;
    measured: Measured;
    result: Result;
    walker: Walker | null;
    points: Point[];
    outlook: Outlook;
    progress: Progress | null;
    gauges: Gauge[];
    campaign: Campaign | null;
    plan_check: PlanCheck | null;
    plans: string[];  // by which a campaign can be ordered
    cameras: Camera[];
    clocks: Clock[];
    losses: Loss[];
    disk: Disk;
    tracking: Tracking;
    jitter: Jitter;
    real_time: RealTimeGrant[];
    switches: Switches;
    limits: Record<string, unknown>;
}

/** An event with the id of an earlier one replaces it: its text has a new count of repeats. */
/** `t_s`: master time; `at`: clock time of this computer, ms. */
export interface LogEvent { id: number; t_s: number; at: number; kind: string; text: string }

/** A measurement; asked: its set-point, with its overtones. A row without a result has null values, and the reason in `ended`. */
export interface ResultRow {
    id: number;
    time: string | null;  // of its end, UTC
    asked: (SetPoint & { overtones: unknown[] }) | null;
    periods: Known;
    gamma_mps2: Estimate | null;
    rho: Estimate | null;
    phi_rad: Estimate | null;
    v_D_mps: Estimate | null;
    D_m: Estimate | null;
    efficiency: Estimate | null;
    steady: boolean;
    notes: string;
    ended: string;
    recording: string | null;
}

/** Steady measurements of one set-point, combined by the daemon. stated, scatter: of v_D of one measurement. */
export interface Repeats {
    asked: SetPoint;
    newest: string | null;
    count: number;
    v_D_mps: Estimate | null;
    D_m: Estimate | null;
    efficiency: Estimate | null;
    stated_mps: number | null;
    scatter_mps: number | null;
}

/** A file of the daemon's folder. Null: not read yet, or not readable because of `trouble`. replay: state or verdict of a check. */
export interface Recording {
    name: string;
    bytes: number;
    changed: string;
    started: string | null;
    outcome: string | null;
    trouble: string | null;
    set_points: SetPoint[];
    remarks: string[];
    replay: string | null;
    replay_text: string | null;
}

/** A folder of a campaign beside the recordings. */
export interface CampaignFolder {
    name: string;
    bytes: number;
    changed: string;
    recordings: number;
    complete: boolean;  // its points table is written
    report: string | null;
    report_text: string | null;
}

export type Message = { type: "state"; state: State } | { type: "event"; event: LogEvent } | { type: "results"; results: ResultRow[] };
