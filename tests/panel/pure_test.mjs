// Tests without a browser: numbers as text, messages, frames, the rolling store, the curves.
import assert from "node:assert/strict";
import test from "node:test";
import { chance } from "./bench.mjs";
import { picture, samples } from "./frames.mjs";
import { closedForm, g, steadyPeriod } from "./motion.mjs";
import { source } from "./sources.mjs";

const { tickTexts, withError, withErrors, number, prefixed, duration, decibels } = await source("format");
const { decodeFrame, channel, FrameError } = await source("frames");
const { edgeLines, figureWords, scaleBar } = await source("views/camera_drawing");
const { campaignWords, checkWords, scanOrder } = await source("views/campaign");
const { resized, rigLines, shifted } = await source("views/target_regions");
const { trackingWords } = await source("views/health");
const { stickWords } = await source("views/numbers");
const { parseMessage } = await source("messages");
const { typed, whole } = await source("quantity");
const { hardwareStopWords } = await source("views/header");
const { Rolling } = await source("rolling");
const { padded } = await source("views/points");
const { newestFirst, pointsOf } = await source("results");
const { curves, axes, degrees, maxCurves } = await source("groups");

const arrayBuffer = (buffers) => new Uint8Array(Buffer.concat(buffers)).buffer;
const decoded = (buffers) => decodeFrame(arrayBuffer(buffers));

test("Regions stay in the picture, and their lines count px of the whole picture", () => {
    const size = { width: 100, height: 50 };
    assert.deepEqual(shifted([10, 10, 30, 20], 5.4, -3, size), [15, 7, 30, 20]);
    assert.deepEqual(shifted([10, 10, 30, 20], 500, 500, size), [70, 30, 30, 20]);
    assert.deepEqual(shifted([10, 10, 30, 20], -500, -500, size), [0, 0, 30, 20]);
    assert.deepEqual(resized([10, 10, 30, 20], -500, 500, size), [10, 10, 4, 40]);
    assert.equal(rigLines([{ camera: "top", target: "walker", region_px: [1, 2, 3, 4] }], [{ name: "top", origin_px: [10, 20] }]),
        '# [[camera]] name = "top", [[camera.target]] name = "walker"\nroi_px = [11, 22, 3, 4]');
});

test("A value has the decimals of its error, which has two digits", () => {
    for (const [value, sigma, scale, text] of [
        [0.014582, 0.000099, 1e3, "14.582 ± 0.099"], [-0.014582, 0.00123, 1e3, "−14.6 ± 1.2"], [0.113, 0.0053, 1, "0.1130 ± 0.0053"],
        [1234, 56, 1, "1234 ± 56"], [123456, 1234, 1, "123456 ± 1234"], [1, 0.0996, 1, "1.00 ± 0.10"], [0.00001, 0.5, 1, "0.00 ± 0.50"],
        [-0.001, 0.5, 1, "0.00 ± 0.50"], [14.5, 0, 1, "14.50 ± 0"], [14.5, null, 1, "14.50"], [null, 1, 1, "–"], [NaN, 1, 1, "–"],
        [1, Infinity, 1, "1.000"],
    ]) assert.equal(withError({ value, sigma }, scale), text);
    assert.equal(withError(null), "–");
    const estimate = { value: 0.0074150, sigma: 1.2e-7 };
    assert.equal(withErrors({ ...estimate, systematic: 3.7e-6 }, 1e3), "7.41500 ± 0.00012 ± 0.0037 syst");
    assert.equal(withErrors(estimate, 1e3), "7.41500 ± 0.00012");
    assert.equal(withErrors(null), "–");
});

test("The rounding of a shown value is less than a tenth of its error", () => {
    const random = chance(1);
    for (let k = 0; k < 2000; k++) {
        const sigma = 10 ** (random() * 9 - 6), value = (random() - 0.5) * sigma * 10 ** (random() * 4);
        const [shown, error] = withError({ value, sigma }).replaceAll("−", "-").split(" ± ").map(Number);
        assert.ok(Math.abs(shown - value) <= Math.min(0.5, sigma / 10), `${value} ${sigma}`);
        assert.ok(Math.abs(error - sigma) <= sigma / 10);
    }
});

test("The check of a plan is told in words, with the points that do not fit", () => {
    const check = { plan: "scan", under_way: false, points: 12, fit: 12, summary: "12 points, 12 fit; bench time 3.1 min", misfits: [] };
    assert.equal(checkWords(check), "Check of scan: 12 points, 12 fit; bench time 3.1 min");
    assert.equal(checkWords({ ...check, under_way: true }), "Check of scan: under way");
    assert.match(checkWords({ ...check, fit: 9, misfits: ["point 3 does not fit: x", "point 4 does not fit: x"] }), /3.1 min; point 3 does not fit: x; point 4 .*; and 1 more$/);
});

test("A campaign is told in words, and a scan is an order in SI units or a refusal", () => {
    const campaign = { active: true, paused: false, doing: "measuring", points: 12, ended: 3, point: "scan phi 35 deg", left_s: 190, known_mu: "", folder: "scan-x" };
    assert.equal(campaignWords(campaign), "measuring: 3 of 12 points have ended; now scan phi 35 deg; about 3 min 10 s left");
    assert.equal(campaignWords({ ...campaign, point: "", left_s: null }), "measuring: 3 of 12 points have ended");
    assert.equal(campaignWords({ ...campaign, point: "", known_mu: "mu 0.113" }), "measuring: 3 of 12 points have ended; mu 0.113; at most 3 min 10 s left");
    assert.match(campaignWords({ ...campaign, active: false }), /^ended: 3 of 12 points; .* are in scan-x$/);
    const fields = { from: "0", to: "180", steps: "6", periods: "20" };
    assert.deepEqual(scanOrder("phi", fields), { body: { scan: "phi", from: "0 deg", to: "180 deg", steps: 6, periods: 20 }, words: "0 deg to 180 deg" });
    assert.equal(scanOrder("gamma", { ...fields, to: "1,5" }).body.to, "1,5 g");
    assert.equal(scanOrder("phi", { ...fields, to: "3 rad" }).words, "0 deg to 3 rad");
    assert.equal(scanOrder("phi", { ...fields, from: "" }).refused, "from: a number is needed");
    assert.equal(scanOrder("gamma", { ...fields, steps: "1.5" }).refused, "steps: a whole number from 1");
    assert.equal(scanOrder("gamma", { ...fields, periods: "1" }).refused, "periods: a whole number from 3");
});

test("A typed number has one decimal sign and perhaps a unit; without one it has the chosen unit", () => {
    const like = (text, sent, value, words) => assert.deepEqual(typed("gamma", text, "g"), { text: sent, value, unit: words.split(" ")[1], words });
    like("0.5", "0.5 g", 0.5, "0.5 g");
    like(" 0,5 ", "0,5 g", 0.5, "0.5 g");
    like("1,5m/s^2", "1,5m/s^2", 1.5, "1.5 m/s^2");
    like("-3.5e1 deg", "-3.5e1 deg", -35, "-35 deg");
    like(".5", ".5 g", 0.5, "0.5 g");
    assert.deepEqual(typed("rho", "50 %", ""), { text: "50 %", value: 50, unit: "%", words: "50 %" });
    assert.deepEqual(typed("rho", "0,5", ""), { text: "0,5", value: 0.5, unit: "", words: "0.5" });
    for (const wrong of ["1,234,567", "1,5.2", "1.5,2", ",5", "1,", "1,g", "g", "--1", "1..2", "0,5 0", "1e999"])
        assert.match(typed("gamma", wrong, "g").refused, /^gamma: "/, wrong);
    assert.equal(typed("gamma", " ", "g").refused, "gamma: a number is needed");
    assert.equal(whole("periods", " 20 ", 2), 20);
    for (const wrong of ["", "1", "2.5", "2,5", "-3", "1e3"]) assert.equal(whole("periods", wrong, 2).refused, "periods: a whole number from 2", wrong);
});

test("The bar asks for the hardware stop 1.5 s after an ABORT without an answer", () => {
    const sending = { state: "sending", attempt: 3, error: "no answer from the daemon", since: 1000 };
    const stop = "No answer from the daemon: press the hardware stop NOW";
    assert.equal(hardwareStopWords(sending, 2400, true), "");
    assert.equal(hardwareStopWords(sending, 2600, true), stop);
    assert.equal(hardwareStopWords({ ...sending, error: null }, 2600, false), stop);
    assert.match(hardwareStopWords({ ...sending, error: "cut the amplifier" }, 2600, false), /^The daemon did not stop the drive \(cut the amplifier\): press/);
    assert.equal(hardwareStopWords({ state: "failed", error: "no answer from the daemon" }, 9e4, true), stop);
    assert.equal(hardwareStopWords({ state: "failed", error: "no answer from the daemon" }, 9e4, false), "", "connected again");
    assert.equal(hardwareStopWords({ state: "done", took_ms: 3000 }, 9e4, true), "");
    assert.equal(hardwareStopWords({ state: "other", error: "x" }, 9e4, true), "");
});

test("Numbers, prefixes, durations and levels have their usual form", () => {
    assert.equal(number(9.8), "9.800");
    assert.equal(number(0), "0");
    assert.equal(number(-0.00012346), "−0.0001235");
    assert.equal(prefixed(1.12e11, "B"), "112 GB");
    assert.equal(prefixed(3.1e-4, "s"), "310 µs");
    assert.equal(prefixed(0.9999, "s"), "1.00 s");
    assert.equal(prefixed(2e-5, "s", 1), "20 µs");
    assert.equal(prefixed(undefined, "s"), "–");
    assert.equal(duration(4.24), "4.2 s");
    assert.equal(duration(187.9), "3 min 07 s");
    assert.equal(duration(7500), "2 h 05 min");
    assert.ok(Math.abs(decibels(0.5, 1) + 6.0206) < 1e-4);
    assert.equal(decibels(0, 1), -Infinity);
    assert.equal(decibels(1, 0), null);
});

test("Ticks have enough decimals to differ", () => {
    assert.deepEqual(tickTexts([1.00002, 1.00004, 1.00006]), ["1.00002", "1.00004", "1.00006"]);
    assert.deepEqual(tickTexts([0, 0.25, 0.5]), ["0.00", "0.25", "0.50"]);
    assert.deepEqual(tickTexts([-0.2, -0.1, 0, 0.1, 0.1 + 0.1 + 0.1]), ["−0.2", "−0.1", "0.0", "0.1", "0.3"]);
    assert.deepEqual(tickTexts([0, 50, 100]), ["0", "50", "100"]);
    assert.deepEqual(tickTexts([1, null, 10]), ["1", "", "10"]);
    assert.deepEqual(tickTexts([124.415]), ["124.4"]);
});

test("Without a stick the text has the shortest detectable one", () => {
    assert.equal(stickWords([[0.5057, 0.7072]], null), "sticks 0.506 to 0.707 T");
    assert.equal(stickWords([], 0.0312), "never sticks for over 0.031 T");
    assert.equal(stickWords([], 1), "sticks: not known, too few frames or slips too short");
    assert.equal(stickWords([], null), "never sticks");
});

test("the share of a processor that tracking takes", () => {
    assert.equal(trackingWords({ median_s: 5e-5, slowest_s: 2e-4, core_share: 0.0712 }), "7.1 % of a processor, 99.9 % below 200 µs");
    assert.equal(trackingWords({ median_s: null, slowest_s: null, core_share: null }), "no pictures");
});

test("A frame of samples is decoded with its flags", () => {
    const frame = decoded(samples(2, [[1, 2, 3], [-1, NaN, 0.5]], { first: 2 ** 40, t0: 12.5, dt: 1e-3, flags: 5 }));
    assert.deepEqual({ ...frame, values: [...frame.values] }, {
        what: "samples", stream: 2, first: 2 ** 40, t0: 12.5, dt: 1e-3, count: 3, channels: 2, gap: true, pairs: false,
        decimated: true, values: [1, -1, 2, NaN, 3, 0.5],
    });
    assert.deepEqual(channel(frame, 1, 2), [-2, null, 1]);
});

test("A picture is decoded with any number of marks", () => {
    const jpeg = Buffer.from([0xff, 0xd8, 1, 2, 3, 0xff, 0xd9]);
    for (let count = 0; count < 10; count++) {
        const marks = Array.from({ length: count }, (_, i) => ({ x: i, y: 2 * i, width: 10.5, height: 4, kind: i }));
        const frame = decoded(picture(1, jpeg, 640, 160, marks, { t0: 3 }));
        assert.deepEqual({ ...frame, jpeg: [...frame.jpeg] },
            { what: "picture", camera: 1, t0: 3, width: 640, height: 160, gap: false, marks, jpeg: [...jpeg] });
    }
});

test("Limits at the edge, scale and figures of a picture", () => {
    const camera = { along: [1, 0], targets: [{ name: "walker" }] }, size = { width: 400, height: 100 };
    assert.deepEqual(edgeLines(camera, 0.005, 4, size), { upright: true, at: [20, 380] });
    assert.deepEqual(edgeLines({ ...camera, along: [0, -1] }, 0.005, 4, size), { upright: false, at: [20, 80] });
    assert.deepEqual(edgeLines({ ...camera, targets: [{ name: "base" }] }, 0.005, 4, size).at, []);
    assert.deepEqual(edgeLines(camera, null, 4, size).at, []);
    assert.deepEqual([scaleBar(4, 400), scaleBar(0.1, 400), scaleBar(39, 400)], [{ mm: 20, px: 80 }, { mm: 500, px: 50 }, { mm: 2, px: 78 }]);
    assert.equal(figureWords({ exposure_s: 1e-3, clipped: 0.05, edge_px: 12 }), "exposed for 1.0 ms, ⚠ 5.0 % clipped, ⚠ blurred: edges 12 px");
    assert.equal(figureWords({ exposure_s: 0, clipped: 0, edge_px: null }), "0 % clipped");
});

test("A truncated frame and one of another kind or version are refused", () => {
    const jpeg = Buffer.alloc(9), mark = { x: 1, y: 2, width: 3, height: 4, kind: 0 };
    for (const whole of [samples(1, [[1, 2], [3, 4]], {}), picture(0, jpeg, 4, 4, [mark], {})]) {
        const bytes = arrayBuffer(whole);
        decodeFrame(bytes);
        for (let size = 0; size < bytes.byteLength; size++) assert.throws(() => decodeFrame(bytes.slice(0, size)), FrameError);
    }
    for (const at of [0, 4]) {
        const bytes = arrayBuffer(samples(1, [[1]], {}));
        new Uint8Array(bytes)[at] ^= 0xff;
        assert.throws(() => decodeFrame(bytes), FrameError);
    }
});

test("A state with missing or null members can be shown", () => {
    const { state } = parseMessage(JSON.stringify({ type: "state", session: { state: "running" }, measured: { harmonics: null }, result: null }));
    assert.equal(state.session.state, "running");
    assert.equal(state.session.recording, null);
    assert.deepEqual(state.measured.harmonics, []);
    assert.equal(state.result.v_D_mps, null);
    assert.deepEqual(state.points, []);
    assert.deepEqual(state.real_time, []);
    assert.deepEqual(state.switches, { abort_contact: null, enable_output: null });
    assert.equal(parseMessage('{"type":"weather"}'), null);
    const { state: later } = parseMessage('{"type":"state","walker":null}', { ...state, points: [1], walker: { x_m: 0 } });
    assert.deepEqual(later.points, [1], "what is left out stays");
    assert.equal(later.walker, null, "what is null goes");
    assert.equal(parseMessage("{"), null);
    assert.equal(parseMessage("null"), null);
});

function frameOf(t0, dt, columns, flags = 0) { return decoded(samples(1, columns, { t0, dt, flags })); }

test("The rolling store keeps only the newest points, in order", () => {
    const rolling = new Rolling(100, 2);
    for (let k = 0; k < 30; k++) {
        const times = Array.from({ length: 7 }, (_, i) => 7 * k + i);
        rolling.push(frameOf(7 * k, 1, [times, times.map((t) => -t)]));
    }
    assert.equal(rolling.size, 100);
    assert.equal(rolling.newest, 209);
    const [time, first, , second] = rolling.envelope(209, 1000, 1000, 1);
    assert.deepEqual(time, Array.from({ length: 100 }, (_, i) => i - 98.5));
    assert.deepEqual(first, Array.from({ length: 100 }, (_, i) => i + 110));
    assert.deepEqual(second, first.map((value) => -value));
});

test("Decimation keeps every extreme in one point per bucket", () => {
    const random = chance(3), rolling = new Rolling(5000, 1);
    const values = Array.from({ length: 5000 }, () => Math.fround(random() - 0.5));
    values[1234] = 7;
    values[4321] = -9;
    rolling.push(frameOf(0, 1 / 1024, [values]));
    const [time, least, greatest] = rolling.envelope(rolling.newest, 4, 64, 1);
    assert.ok(time.length === 64 || time.length === 65);
    assert.equal(Math.max(...greatest), 7);
    assert.equal(Math.min(...least), -9);
    for (let i = 1; i + 1 < time.length; i++) {
        const middle = (time[i] + rolling.newest) * 1024;
        const bucket = values.slice(middle - 32, middle + 32);
        assert.equal(least[i], Math.min(...bucket));
        assert.equal(greatest[i], Math.max(...bucket));
    }
});

test("A gap interrupts the line; a backward step of time restarts it", () => {
    const rolling = new Rolling(100, 1);
    rolling.push(frameOf(0, 1, [[1, 2]]));
    rolling.push(frameOf(5, 1, [[3]], 1));
    assert.deepEqual(rolling.envelope(5, 10, 10, 1)[1], [1, 2, null]);
    rolling.push(frameOf(6, 1, [[4, 5]]));
    assert.deepEqual(rolling.envelope(7, 10, 10, 1)[1], [1, 2, null, 4, 5]);
    rolling.push(frameOf(1, 1, [[9]]));
    assert.deepEqual(rolling.envelope(1, 10, 50, 1)[1], [9]);
});

test("Each sweep becomes one curve, in order; other points are last", () => {
    const points = [];
    for (const gamma of [3, 1, 2]) for (const phi of [Math.PI / 2, 0])
        points.push({ gamma_mps2: gamma * g, phi_rad: phi, v_D_mps: gamma / 1e3, sigma_mps: 1e-4, closed_form_mps: null });
    points.push({ gamma_mps2: g, phi_rad: -3, v_D_mps: 0, sigma_mps: null, closed_form_mps: 1e-3 });
    points.push({ ...points[0], v_D_mps: null });
    const found = curves(points, axes.gamma);
    assert.deepEqual(found.map((curve) => [curve.label, curve.single, curve.points.map((p) => Math.round(p.x))]),
        [["φ = 0°", false, [1, 2, 3]], ["φ = 90°", false, [1, 2, 3]], ["others", true, [1]]]);
    assert.deepEqual(found[2].points[0].closed, 1);
    const many = Array.from({ length: 60 }, (_, i) => ({ ...points[0], phi_rad: (i % 20) * 0.1 }));
    assert.equal(curves(many, axes.gamma).length, maxCurves + 1);
});

const rowAt = (id, second, v, sigma, more = {}) => ({
    id, time: `2026-11-26T10:00:0${second}Z`, asked: { frequency_hz: 20, gamma_mps2: g, rho: 0.5, phi_rad: 1, overtones: [] },
    v_D_mps: { value: v, sigma }, D_m: null, efficiency: null, ...more,
});

test("Rows are the newest first, those without a time last", () => {
    const rows = [rowAt(1, 1, 1, 1), rowAt(4, 4, 3, 1), rowAt(5, 0, 7, 1, { time: null })];
    assert.deepEqual(newestFirst(rows).map((row) => row.id), [4, 1, 5]);
});

test("Points have the set-points of their rows; rows of before the daemon's start are points, too", () => {
    const measured = { gamma_mps2: 9.81, phi_rad: 1, v_D_mps: 0.0066, sigma_mps: 1e-6, closed_form_mps: 0.007 };
    const some = (value) => ({ value, sigma: 1e-6 });
    const row = rowAt(1, 1, 0.0066, 1e-6, { gamma_mps2: some(9.81), phi_rad: some(1) }), before = rowAt(2, 2, 0.005, 1e-6, { gamma_mps2: some(9.9), phi_rad: some(2) });
    assert.deepEqual(pointsOf([measured], [row, before, rowAt(3, 3, 0, 0, { v_D_mps: null })]),
        [{ ...measured, asked: row.asked }, { gamma_mps2: 9.9, phi_rad: 2, v_D_mps: 0.005, sigma_mps: 1e-6, closed_form_mps: null, asked: before.asked }]);
    assert.deepEqual(pointsOf([measured], []), [measured]);
});

test("An axis of repeats is not narrower than its least span", () => {
    assert.deepEqual(padded(0.99, 1.01, 0.2).map((x) => Math.round(100 * x)), [90, 110]);
    assert.deepEqual(padded(0, 10, 0.2).map((x) => Math.round(100 * x)), [-50, 1050]);
});

test("An angle is shown within half a turn of zero", () => {
    const near = (a, b) => assert.ok(Math.abs(a - b) < 1e-9, `${a} ${b}`);
    near(degrees((3 * Math.PI) / 2), -90);
    near(degrees(-Math.PI), 180);
    near(degrees(7 * Math.PI), 180);
});

test("The simulated walker drifts like a Coulomb walker; the closed form agrees without stick", () => {
    const drive = { frequency_hz: 20, gamma_mps2: g, rho: 0.5, phi_rad: 0 };
    const { drift, period } = steadyPeriod(drive, 0.113);
    assert.ok(Math.abs(drift / period - 14.582e-3) < 2e-5);
    assert.ok(Math.abs(closedForm(drive, 0.113) - 14.582e-3) < 2e-6);
});

const { tripWords, limitLines } = await source("views/trip");
const { edgeWords } = await source("views/forms");
const { edgeZone } = await source("views/numbers");

test("A trip is one sentence with its time and what to do; the limit is a line of its plot", () => {
    const trip = { cause: "walker_edge", finding: "the walker is 4.97 mm from the edge of the picture (at least 5 mm)", advice: "clear the trip", value: 4.97, limit: 5, t_s: 1, age_s: 0, recording: null };
    assert.equal(tripWords(trip, "17:03:21"), "Tripped at 17:03:21: the walker is 4.97 mm from the edge of the picture (at least 5 mm). Clear the trip.");
    assert.equal(tripWords({ ...trip, finding: "stopped by the operator", advice: "", recording: "a.nxs" }, "1:00"), "Tripped at 1:00: stopped by the operator. Recorded in a.nxs.");
    const lines = (walker) => limitLines({ walker }, trip).map((mm) => Math.round(mm * 100) / 100);
    assert.deepEqual(lines({ x_m: 0.08903, left_m: 0, right_m: 0.1, edge_m: 0.00497 }), [89]);  // a walker with a radius of 6 mm
    assert.deepEqual(lines({ x_m: 0.08903, left_m: 0.1, right_m: 0, edge_m: 0.00497 }), [89]);
    assert.deepEqual(lines({ x_m: 0.01, left_m: 0, right_m: 0.1, edge_m: 0.004 }), [11]);
    assert.deepEqual(lines(null), []);
    assert.deepEqual(limitLines({ walker: null }, { ...trip, cause: "acceleration", limit: 60 }), [-60, 60]);
    assert.deepEqual(limitLines({ walker: null }, { ...trip, cause: "residual", limit: 60 }), []);
});

test("The way back is offered at rest, to a walker at the edge", () => {
    const at = (edge_m, state) => edgeWords({ walker: { x_m: 0, left_m: 0, right_m: 0.1, edge_m }, limits: { edge_m: 0.005 }, session: { state } });
    assert.match(at(0.0049, "idle"), /^The walker is 4\.9 mm from the edge of the picture \(limit 5\.0 mm\)\. Bring it to the middle/);
    assert.match(at(0.0055, "armed"), /^The walker is 5\.5 mm/);
    assert.equal(at(0.007, "idle"), "");
    assert.equal(at(0.004, "running"), "");
    assert.equal(at(null, "idle"), "");
    assert.equal(Math.round(1e3 * edgeZone({ x_m: 0.03, left_m: 0, right_m: 0.1, edge_m: 0.024 }, 0.005)), 110);
    assert.equal(edgeZone({ x_m: 0.03, left_m: null, right_m: 0.1, edge_m: 0.024 }, 0.005), 0);
});
