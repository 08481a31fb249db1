// The results with their errors, the drive as asked and as measured, and where the walker is.
import { byId, setText } from "../dom";
import { decimalsFor, fixed, number, prefixed, unknown, withError } from "../format";
import { degrees, paperG } from "../groups";
import type { Known, Walker } from "../protocol";
import type { Store } from "../store";

function acceleration(value: Known): string {
    return value === null ? unknown : `${number(value / paperG)} g (${number(value)} m/s²)`;
}

function angle(value: Known): string {
    return value === null ? unknown : `${fixed(degrees(value), 2)}° (${fixed((degrees(value) * Math.PI) / 180, 4)} rad)`;
}

function millimetres(metres: number): string { return `${fixed(metres * 1e3, 1)} mm`; }

export function makeNumbers(store: Store): () => void {
    const ids = [
        "v-D", "D", "efficiency", "mu", "gamma", "gamma-asked", "phi", "phi-asked", "frequency", "rho", "rms", "volts",
        "steady",
    ] as const;
    const at = Object.fromEntries(ids.map((id) => [id, byId(id, HTMLElement)])) as Record<(typeof ids)[number], HTMLElement>;
    const showWalker = makeWalker();
    let seen = -1;

    return () => {
        const { state } = store;
        if (!state || seen === store.stateVersion) return;
        seen = store.stateVersion;
        const { result, drive, measured } = state;
        setText(at["v-D"], withError(result.v_D_mps, 1e3));
        setText(at.D, withError(result.D_m, 1e3));
        setText(at.efficiency, withError(result.efficiency, 100));
        setText(at.mu, withError(result.mu));
        const periods = result.periods === null ? "" : `, ${result.periods} periods`;
        setText(at.steady, (result.steady ? "✓ steady" : "… not steady yet") + periods);
        setText(at.gamma, acceleration(measured.gamma_mps2));
        setText(at["gamma-asked"], acceleration(drive.gamma_mps2));
        setText(at.phi, angle(measured.phi_rad));
        setText(at["phi-asked"], angle(drive.phi_rad));
        setText(at.frequency, drive.frequency_hz === null ? unknown : `${exact(drive.frequency_hz)} Hz`);
        setText(at.rho, drive.rho === null ? unknown : exact(drive.rho));
        setText(at.rms, measured.rms_mps2 === null ? unknown : `${number(measured.rms_mps2)} m/s²`);
        setText(at.volts, prefixed(measured.volts_peak, "V"));
        showWalker(state.walker);
    };
}

/** A setting as it was given: no digits that nobody typed. */
function exact(value: number): string {
    const digits = value.toPrecision(9);
    const typed = digits.replace(/0+$/, "").split(".")[1]?.length ?? 0;
    return fixed(Number(digits), Math.min(decimalsFor(Math.abs(value), 9), typed));
}

function makeWalker(): (walker: Walker | null) => void {
    const track = byId("walker-track", HTMLElement), mark = byId("walker-mark", HTMLElement);
    const low = byId("walker-low", HTMLElement), high = byId("walker-high", HTMLElement);
    return (walker) => {
        mark.hidden = walker === null;
        setText(low, walker ? millimetres(walker.low_m) : "walker: not seen");
        setText(high, walker ? millimetres(walker.high_m) : "");
        if (!walker) {
            track.removeAttribute("aria-valuenow");
            return;
        }
        const share = (walker.x_m - walker.low_m) / (walker.high_m - walker.low_m);
        mark.style.left = `${Math.min(1, Math.max(0, share)) * 100}%`;
        track.setAttribute("aria-valuemin", fixed(walker.low_m * 1e3, 1).replace("−", "-"));
        track.setAttribute("aria-valuemax", fixed(walker.high_m * 1e3, 1).replace("−", "-"));
        track.setAttribute("aria-valuenow", fixed(walker.x_m * 1e3, 1).replace("−", "-"));
    };
}
