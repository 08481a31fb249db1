// The results with their errors, the requested and the measured drive, and the walker's position.
import { byId, setText } from "../dom";
import { clockTime, decimalsFor, fixed, number, prefixed, unknown, withError, withErrors } from "../format";
import { degrees, paperG } from "../groups";
import type { Estimate, Known, Result, State, Walker } from "../protocol";
import type { Store } from "../store";

function acceleration(value: Known): string {
    return value === null ? unknown : `${number(value / paperG)} g (${number(value)} m/s²)`;
}

function angle(value: Known): string {
    return value === null ? unknown : `${fixed(degrees(value), 2)}° (${fixed((degrees(value) * Math.PI) / 180, 4)} rad)`;
}

function millimetres(metres: Known): string { return metres === null ? unknown : `${fixed(metres * 1e3, 1)} mm`; }

/** How much a ratio exceeds 1: "+0.02 ± 0.04 %". */
function excess(ratio: Estimate | null): string {
    if (ratio === null || ratio.value === null) return unknown;
    return `${withError({ value: ratio.value - 1, sigma: ratio.sigma }, 100)} %`;
}

export function makeNumbers(store: Store): () => void {
    const ids = [
        "v-D", "D", "efficiency", "mu", "gamma", "gamma-asked", "phi", "phi-asked", "frequency", "rho", "rms", "ratio", "volts",
        "steady",
    ] as const;
    const at = Object.fromEntries(ids.map((id) => [id, byId(id, HTMLElement)])) as Record<(typeof ids)[number], HTMLElement>;
    const showWalker = makeWalker(), showOrigin = makeOrigin();
    let seen = -1;

    return () => {
        const { state } = store;
        if (!state || seen === store.stateVersion) return;
        seen = store.stateVersion;
        const { result, drive, measured } = state;
        setText(at["v-D"], withErrors(result.v_D_mps, 1e3));
        setText(at.D, withErrors(result.D_m, 1e3));
        setText(at.efficiency, withErrors(result.efficiency, 100));
        setText(at.mu, result.mu_refused ? unknown : withError(result.mu));
        setText(at.ratio, excess(result.bench_check) + (result.bench_alarm ? ", they disagree" : ""));
        showOrigin(result);
        setText(at.steady, steadyWords(state));
        setText(at.gamma, acceleration(measured.gamma_mps2));
        setText(at["gamma-asked"], acceleration(drive.gamma_mps2));
        setText(at.phi, angle(measured.phi_rad));
        setText(at["phi-asked"], angle(drive.phi_rad));
        setText(at.frequency, drive.frequency_hz === null ? unknown : `${exact(drive.frequency_hz)} Hz`);
        setText(at.rho, drive.rho === null ? unknown : exact(drive.rho));
        setText(at.rms, measured.rms_mps2 === null ? unknown : `${number(measured.rms_mps2)} m/s²`);
        setText(at.volts, prefixed(measured.volts_peak, "V"));
        showWalker(state.walker, state.limits["edge_m"]);
    };
}

/** Empty at rest. */
function steadyWords({ result, session }: State): string {
    if (session.state !== "settling" && session.state !== "running") return "";
    return `${result.steady ? "✓ steady" : "… not steady yet"}, ${result.periods ?? unknown} periods`;
}

/** A setting with the digits that the operator gave. */
function exact(value: number): string {
    const digits = value.toPrecision(9);
    const typed = digits.replace(/0+$/, "").split(".")[1]?.length ?? 0;
    return fixed(Number(digits), Math.min(decimalsFor(Math.abs(value), 9), typed));
}

/** Number, time and set-point of the result. A result of another set-point than the requested one is grey. */
function makeOrigin(): (result: Result) => void {
    const line = byId("result-of", HTMLElement), cards = ["results", "cycle-card"].map((id) => byId(id, HTMLElement));
    let of: Known = null, when = "";
    return (result) => {
        for (const card of cards) card.classList.toggle("old", result.number !== null && !result.current);
        if (result.number === null) return setText(line, "");
        if (of !== result.number) when = clockTime(result.age_s ?? 0);
        of = result.number;
        setText(line, originWords(result, when));
    };
}

/** "sticks 0.506 to 0.707 T"; without stick, the shortest interval that would have been detected. */
export function stickWords(stick: Result["stick"], shortest: Known): string {
    if (stick.length) return `sticks ${stick.map(([from, to]) => `${fixed(from, 3)} to ${fixed(to, 3)} T`).join(", ")}`;
    if (shortest === null) return "never sticks";
    return shortest >= 1 ? "sticks: not known, too few frames or slips too short" : `never sticks for over ${fixed(shortest, 3)} T`;
}

function originWords({ number: count, drive, current, stick, shortest_visible_stick, mu_refused }: Result, when: string): string {
    const at = drive === null ? "" :
        `: γ ${acceleration(drive.gamma_mps2)}, φ ${angle(drive.phi_rad)}, f ${number(drive.frequency_hz)} Hz, ρ ${number(drive.rho, 3)}`;
    return `${current ? "" : "⚠ The set-point has changed since. "}Measurement ${count} at ${when}${at}; ${stickWords(stick, shortest_visible_stick)}${
        mu_refused ? `; no single μ: ${mu_refused}` : ""}`;
}

/** Share of the picture, at each end, that the walker's middle may not enter. */
export function edgeZone({ x_m, left_m, right_m, edge_m }: Walker, limit: unknown): number {
    if (left_m === null || right_m === null || edge_m === null || typeof limit !== "number") return 0;
    const nearer = Math.min(Math.abs(x_m - left_m), Math.abs(right_m - x_m));
    return Math.min(0.5, (nearer - edge_m + limit) / Math.abs(right_m - left_m));
}

function placeWords({ x_m, edge_m }: Walker, limit: unknown): string {
    const words = `walker at ${fixed(1e3 * x_m, 1)} mm`;
    if (edge_m === null) return words;
    const least = typeof limit === "number" ? ` (limit ${fixed(1e3 * limit, 1)} mm)` : "";
    return `${words}, ${fixed(1e3 * edge_m, 1)} mm from the edge${least}`;
}

/** Position of the walker between the ends of its camera's picture, oriented as in the picture. */
function makeWalker(): (walker: Walker | null, limit: unknown) => void {
    const track = byId("walker-track", HTMLElement), mark = byId("walker-mark", HTMLElement);
    const low = byId("walker-low", HTMLElement), high = byId("walker-high", HTMLElement), at = byId("walker-at", HTMLElement);
    const zones = [byId("edge-low", HTMLElement), byId("edge-high", HTMLElement)];
    return (walker, limit) => {
        mark.hidden = walker === null;
        const left = walker?.left_m ?? null, right = walker?.right_m ?? null;
        setText(low, walker ? millimetres(left) : "walker: not seen");
        setText(high, walker ? millimetres(right) : "");
        setText(at, walker ? placeWords(walker, limit) : "");
        const zone = walker ? edgeZone(walker, limit) : 0;
        for (const element of zones) element.style.width = `${100 * zone}%`;
        if (!walker || left === null || right === null) {
            mark.hidden = true;
            track.removeAttribute("aria-valuenow");
            return;
        }
        const share = (walker.x_m - left) / (right - left);
        mark.style.left = `${Math.min(1, Math.max(0, share)) * 100}%`;
        const shown = (metres: number): string => fixed(metres * 1e3, 1).replace("−", "-");
        track.setAttribute("aria-valuemin", shown(Math.min(left, right)));
        track.setAttribute("aria-valuemax", shown(Math.max(left, right)));
        track.setAttribute("aria-valuenow", shown(walker.x_m));
    };
}
