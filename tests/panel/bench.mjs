// The simulated bench of the page's tests: states, drive and results as the daemon sends them. The caller gives the time,
// a seed gives the randomness.
import { closedForm, g, lawCurves, steadyPeriod } from "./motion.mjs";

const mu = 0.113;
const reach = 0.03;  // m, of the walker to either side of x = middle
const radius = 0.006;  // m, of the walker
const middle = 0.05;  // m, of the picture: x is 0 at its left end

/** mulberry32: equal numbers for equal seeds. */
export function chance(seed) {
    return () => {
        seed = (seed + 0x6d2b79f5) | 0;
        let t = Math.imul(seed ^ (seed >>> 15), 1 | seed);
        t = (t + Math.imul(t ^ (t >>> 7), 61 | t)) ^ t;
        return ((t ^ (t >>> 14)) >>> 0) / 4294967296;
    };
}

const next = { identifying: ["armed", 2], ramping: ["settling", 1], settling: ["running", 2], stopping: ["idle", 0.5] };
const ranges = { frequency_hz: [1, 200], gamma_mps2: [0, 40], rho: [0, 1], phi_rad: [-7, 7] };

const driven = ["identifying", "ramping", "settling", "running", "stopping"];
const units = { "": 1, g, "m/s^2": 1, deg: Math.PI / 180, rad: 1, Hz: 1 };

/** As the daemon reads a number of an order: SI, or a text with a unit and perhaps a decimal comma. */
function quantity(value) {
    if (typeof value !== "string") return value;
    const [, figures, unit] = /^(\S+?)\s*([a-z][a-z/^2]*)?$/i.exec(value);
    return Number(figures.replace(",", ".")) * units[unit ?? ""];
}

export class Bench {
    daemon = "0123456789abcdef";
    time = 0;
    state = "idle";
    since = 0;
    drive = { frequency_hz: 20, gamma_mps2: g, rho: 0.5, phi_rad: 0 };
    control = false;
    recording = null;
    record_next = false;
    record_name = null;
    held = null;  // the newest result
    measurements = 0;
    trip = null;
    periods = 0;
    level = 0;  // of the drive, 0 to 1
    x = 0;
    events = [];
    logged = 0;
    points = [];
    recordings = [];
    campaigns = [];
    rows = [];  // of the table of results
    repeats = [];  // as the daemon combines them
    random = chance(7);
    unfinished = false;  // no measurement becomes complete
    edge = 0.005;  // m, limit
    asked = 0;  // measurements of the run; 0: until stopped
    to_middle = false;  // the walker is being brought to the middle
    given_mu = null;
    walker_lost = false;  // by both cameras
    regions = { top: [170, 30, 120, 110], side: [170, 20, 120, 90] };  // of the walker, px
    mirrored = false;  // x grows to the left of the picture

    law_mu = null;  // value and error, for the curves of the law

    constructor(tell) {
        this.tell = tell;
        this.motion = steadyPeriod(this.drive, mu);
        this.sweep();
        this.log("info", "the bench is open: sim:");
    }

    log(kind, text) {
        const event = { type: "event", id: ++this.logged, t_s: this.time, kind, text };
        this.events = [...this.events, event].slice(-200);
        this.tell(event);
    }

    become(state) {
        this.state = state;
        this.since = this.time;
        if (state === "running") this.periods = 0;
        this.log("state", state);
    }

    /** A measurement at the present set-point; more: members that differ. */
    measure(v_D_mps, more = {}) {
        const { gamma_mps2, phi_rad, rho, frequency_hz } = this.drive, some = (value, sigma) => ({ value, sigma });
        const row = {
            id: this.rows.length + 1, time: new Date(Date.now() - 60_000 + 1000 * this.rows.length).toISOString(), asked: { frequency_hz, gamma_mps2, rho, phi_rad, overtones: [] },
            periods: 20, gamma_mps2: some(gamma_mps2 * 1.0003, 0.001), rho: some(rho, 1e-4), phi_rad: some(phi_rad, 1e-4), v_D_mps: some(v_D_mps, 1e-6),
            D_m: some(v_D_mps / frequency_hz, 5e-8), efficiency: some(0.33, 1e-4), steady: true, notes: "", ended: "complete", recording: "series.nxs", ...more,
        };
        this.rows.push(row);
        this.tell({ type: "results", results: [row] });
    }

    /** Points as a series left them: five phases against gamma, two amplitudes against phi. */
    sweep() {
        const add = (gamma, phi) => {
            const drive = { ...this.drive, gamma_mps2: gamma * g, phi_rad: phi };
            const { drift, period } = steadyPeriod(drive, mu, 100, 500);
            const sigma = 0.0002 + 0.0001 * gamma;
            this.points.push({
                gamma_mps2: gamma * g, phi_rad: phi, v_D_mps: drift / period + (this.random() - 0.5) * 2 * sigma,
                sigma_mps: sigma, closed_form_mps: closedForm(drive, mu),
            });
        };
        for (const phi of [0, Math.PI / 4, Math.PI / 2, (3 * Math.PI) / 4])
            for (let gamma = 0.5; gamma <= 3.01; gamma += 0.25) add(gamma, phi);
        for (const gamma of [1, 3]) for (let k = -6; k <= 6; k++) add(gamma, (k * Math.PI) / 6);
    }

    law() { return this.law_mu ? lawCurves(this.drive, this.law_mu) : { mu: null }; }

    step(dt) {
        this.time += dt;
        if (this.to_middle) return this.lead(dt);
        const [after, seconds] = next[this.state] ?? [];
        if (after && this.time - this.since > seconds) this.become(after);
        const wanted = ["ramping", "settling", "running"].includes(this.state) ? 1 : this.state === "identifying" ? 0.1 : 0;
        this.level += Math.max(-dt / 0.05, Math.min(dt / 0.5, wanted - this.level));
        if (this.state === "running") this.periods += dt * this.drive.frequency_hz;
        this.x += (this.level * dt * this.motion.drift) / this.motion.period;
        if (Math.abs(this.x) > reach) this.x = -Math.sign(this.x) * reach;
    }

    lead(dt) {
        this.x -= Math.sign(this.x) * Math.min(Math.abs(this.x), 0.02 * dt);
        if (this.x !== 0) return;
        this.to_middle = false;
        this.become("idle");
    }

    acceleration(t) {
        const { frequency_hz: f, gamma_mps2: gamma, rho, phi_rad: phi } = this.drive, p = 2 * Math.PI * f * t;
        const target = this.level * gamma * (rho * Math.sin(p) + (1 - rho) * Math.sin(2 * p + phi));
        return [target, target * 1.001 + this.level * 0.05 * Math.sin(3 * p) + (this.random() - 0.5) * 0.4];
    }

    harmonics() {
        const { gamma_mps2: gamma, rho } = this.drive;
        return Array.from({ length: 8 }, (_, i) => {
            const target = this.level * gamma * ([rho, 1 - rho][i] ?? 0);
            const wobble = this.level * (this.random() - 0.5);
            return {
                n: i + 1, target_mps2: target, measured_mps2: Math.abs(target * (1 + 4e-4 * wobble) + 8e-3 * wobble / (i + 1)),
                phase_error_rad: target ? 1.2e-3 * wobble : null, sigma_mps2: 0.0015,
            };
        });
    }

    message() {
        const { drift, period } = this.motion, some = this.state === "running" && this.periods > 4 && !this.unfinished;
        const error = 1 / Math.sqrt(Math.max(1, this.periods));
        const estimate = (value, sigma) => some ? { value: value + (this.random() - 0.5) * sigma, sigma } : null;
        const v = drift / period, scale = this.drive.gamma_mps2 / (2 * Math.PI * this.drive.frequency_hz);
        return {
            type: "state",
            session: {
                state: this.state, since_s: this.time - this.since, rig: "sim:", recording: this.recording, finishing: false, may_clear: true, record_next: this.record_next, frames: "first-second", record_name: this.record_name,
                controller: this.control ? "this page" : null, you_control: this.control, simulated: true, to_middle: this.to_middle,
                trip: this.trip && { value: 0, limit: 0, recording: null, pictures: 2, age_s: this.time - this.trip.t_s, ...this.trip },
                program: "shakerd", version: "0.1.0", daemon: this.daemon,
            },
            drive: { ...this.drive, locked: this.level === 1 },
            measured: {
                gamma_mps2: this.level > 0.5 ? this.drive.gamma_mps2 * 1.0003 : null, phi_rad: this.level > 0.5 ? this.drive.phi_rad + 4e-4 : null,
                harmonics: this.harmonics(), rms_mps2: this.level * this.drive.gamma_mps2 / 2, volts_peak: 0.412 * this.level,
            },
            result: {
                ...this.newest(some, {
                    v_D_mps: estimate(v, 1e-6 * error), D_m: estimate(drift, 5e-8 * error),
                    efficiency: estimate(Math.abs(v) / (scale * Math.sqrt(5 / 32)), 1e-4 * error), mu: estimate(mu, 7e-5 * error),
                    bench_check: estimate(1.0002, 3e-4 * error), bench_alarm: false, mu_refused: this.mu_refused ?? "",
                    friction: [-0.06, -0.02, 0.01, 0.03].map((v) => [v, 0.113 + 0.36 * Math.abs(v), 1e-3 * (1 + 0.5 * Math.sin(this.time))]),
                }),
                periods: Math.floor(this.periods), steady: this.periods > 20,
            },
            walker: { x_m: middle + this.x, left_m: this.mirrored ? 2 * middle : 0, right_m: this.mirrored ? 0 : 2 * middle, edge_m: middle - Math.abs(this.x) - radius },
            points: this.points,
            outlook: { before_periods: 60, walking_periods: 20, walk_mps: { value: v, sigma: 1e-4 }, walk_from: "Coulomb's law", way_m: reach - Math.sign(v) * this.x, recorded: { off: { bytes_per_s: 5e5, first_bytes: 0 }, "first-second": { bytes_per_s: 5e5, first_bytes: 5e7 }, region: { bytes_per_s: 4.9e7, first_bytes: 0 }, full: { bytes_per_s: 4.9e7, first_bytes: 0 } } },
            progress: this.progress(), gauges: this.gauges(), campaign: null, plan_check: null, plans: ["fig3", "mu"],
            clocks: [{ name: "DAC", ppm: 0, residual_s: 2.1e-6 }, { name: "accelerometer", ppm: -37.52, residual_s: 3.4e-6 },
                { name: "camera top", ppm: 12.04, residual_s: 1.1e-6 }, { name: "camera side", ppm: 11.87, residual_s: 1.2e-6 }],
            losses: [{ stream: "accelerometer", got: Math.floor(this.time * 4000), lost: 0 },
                { stream: "camera:top", got: Math.floor(this.time * 1000), lost: 3 },
                { stream: "camera:side", got: Math.floor(this.time * 1000), lost: 0 }],
            cameras: [["top", 320], ["side", 240]].map(([name, height_px]) => ({
                name, width_px: 1280, height_px, origin_px: [0, 40], mm_per_px: 0.078125, along: [1, 0], exposure_s: 2e-4, clipped: 0.002, edge_px: 2.4, not_found: this.not_found?.[name] ?? null,
                targets: [{ name: "walker", region_px: this.regions[name], proposed_px: this.walker_lost ? null : [this.regions[name][0] + 300, ...this.regions[name].slice(1)] }],
            })),
            disk: { free_bytes: 1.12e11, room_bytes: 1.11e11, backlog: 0.042 },
            tracking: { median_s: 5e-5, slowest_s: 2e-4, core_share: 0.071 },
            jitter: {
                bins_s: [1e-6, 2e-6, 5e-6, 1e-5, 2e-5, 5e-5, 1e-4, 2e-4, 5e-4, 1e-3],
                counts: [0, 40, 900, 4200, 2600, 410, 55, 9, 1, 0].map((count) => Math.floor(count * (1 + this.time / 10))),
                worst_s: 3.1e-4,
            },
            switches: { abort_contact: "open", enable_output: false },
            real_time: [{ what: "memory", refused: "memory cannot be locked: only 8192 kB may be locked" }, { what: "output", refused: null }],
            limits: { edge_m: this.edge, acceleration_abort_mps2: 60, displacement_abort_mm: 4, drive_abort_V: 2 },
        };
    }

    progress() {
        if (!["ramping", "settling", "running"].includes(this.state) || this.to_middle) return null;
        const settles = this.state !== "running";
        return {
            measurement: 1 + Math.floor(this.periods / 20), measurements: this.asked, periods_done: settles ? 0 : Math.floor(this.periods) % 20, left_s: 3.2,
            waits_for: settles ? "the base is not within 0.1 % of its target yet (newest period: 0.84 % off)" : null, walk_mps: 0.0146, periods_left: settles ? null : 38,
        };
    }

    gauges() {
        const live = (value) => this.level > 0 ? this.level * value : null, gamma = this.drive.gamma_mps2;
        return [["acceleration", 0.88 * gamma, 60, "m/s^2"], ["velocity", 0.0055 * gamma, 1.3, "m/s"], ["displacement", 0.031 * gamma, 4, "mm"],
            ["force", 0.45 * gamma, 40, "N"], ["drive", 0.042 * gamma, 1, "V"]].map(([quantity, value, limit, unit]) => ({ quantity, unit, limit, set_point: value, live: live(value) }));
    }

    /** The present result, or the last one with its set-point. */
    newest(some, values) {
        if (some) this.held = { ...values, number: ++this.measurements, drive: this.drive, at: this.time };
        if (!this.held) return { ...values, number: null };
        const { at, ...result } = this.held;
        return { ...result, age_s: this.time - at, stick: [], shortest_visible_stick: 0.031, current: JSON.stringify(result.drive) === JSON.stringify(this.drive) };
    }

    /** Carries out an action: null, or the reason of its refusal. */
    act(name, body, daemon = null) {
        if (name === "abort") {
            if (daemon !== null && daemon !== this.daemon && !driven.includes(this.state)) return "the abort was for a daemon that has ended; this one was started since, is at rest and did nothing";
            this.trip = { cause: "operator_stop", finding: "stopped by the operator", advice: "", t_s: this.time };
            this.become("tripped");
            return null;
        }
        if (name === "control/request") return (this.control = true, null);
        if (!this.control) return "another has control: request it first";
        switch (name) {
            case "control/release": this.control = false; return null;
            case "clear": this.trip = null; this.become("idle"); return null;
            case "drive": return this.set(body);
            case "identify": this.become("identifying"); return null;
            case "start": return this.start(body);
            case "middle": return this.bring();
            case "reset-walker": this.x = 0; this.log("note", "the simulated walker is put back"); return null;
            case "targets": return this.move(body.targets);
            case "mu": return this.take(body.mu);
            case "stop": this.become("stopping"); return null;
            case "campaigns/scan-1/report": this.campaigns[0].report = "made"; return null;
            case "recordings/series.nxs/replay": this.recordings[0].replay = "identical"; return null;
            case "record": return this.record(body.name);
            case "remark": this.log("remark", body.text); return null;
            default: return `no action ${name}`;
        }
    }

    move(targets) {
        for (const { camera, target, region_px: [x, y, width, height] } of targets)
            if (width < 40) return `camera "${camera}", target "${target}", roi_px [${x}, ${y}, ${width}, ${height}]: not found`;
        for (const { camera, region_px } of targets) this.regions[camera] = region_px;
        return null;
    }

    take(typed) {
        const mu = quantity(typed);
        if (!(mu >= 0.005 && mu <= 3)) return `mu "${typed}": out of range (units understood: none, %; allowed: 0.005 to 3)`;
        this.given_mu = mu;
        return null;
    }

    bring() {
        if (this.state !== "idle") return `bringing the walker to the middle cannot start in state ${this.state}`;
        this.to_middle = true;
        this.become("settling");
        return null;
    }

    /** Requests the recording of the next run; tests of an open recording set `recording`. */
    record(name) {
        if (name === "taken") return `/var/lib/shakerd/${name}.nxs: exists already; recordings are never overwritten, choose another name`;
        this.recording = null;
        this.record_next = name !== null;
        this.record_name = name;
        this.log("record", name ?? "ended");
        return null;
    }

    start({ measurements, periods, ...drive }) {
        if (Object.keys(drive).length > 0) {
            const refused = this.set(drive);
            if (refused) return refused;
        }
        if (this.state !== "armed") return `start: the state is ${this.state}, it must be armed`;
        this.asked = measurements;
        this.become("ramping");
        this.held = null;
        if (this.record_next) this.recording = `${this.record_name}.nxs`;
        return null;
    }

    set(typed) {
        if (this.state === "tripped") return "drive: tripped; clear the trip first";
        const body = Object.fromEntries(Object.entries(typed).map(([key, value]) => [key, quantity(value)]));
        for (const [key, value] of Object.entries(body)) {
            const [low, high] = ranges[key] ?? [];
            if (!(value >= low && value <= high)) return `${key} = ${value}: allowed ${low} to ${high}`;
        }
        this.drive = { ...this.drive, ...body };
        this.motion = steadyPeriod(this.drive, mu);
        this.periods = 0;
        if (this.state === "idle") this.become("armed");
        return null;
    }
}
