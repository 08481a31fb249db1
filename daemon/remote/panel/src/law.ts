// v_D by the law against gamma and phi at the set-point, as the daemon computes it for the known friction.
import type { Reader } from "./actions";
import type { Known } from "./protocol";
import type { Store } from "./store";

/** v_D in m/s. `low`, `high`: within the error of mu. */
export interface LawValues { at_mu: Known[]; low: Known[]; high: Known[] }
export interface LawCurve { x: number[]; exact_mps: LawValues; closed_form_mps: LawValues }
export interface Law { mu: number; sigma: Known; gamma_mps2: number; phi_rad: number; gamma: LawCurve; phi: LawCurve }

/** Null: no answer of this form, for example because mu is not known. */
export function lawOf(answer: unknown): Law | null {
    const raw = answer as { mu?: Known; gamma?: { gamma_mps2: number[] }; phi?: { phi_rad: number[] } } | null;
    if (typeof raw?.mu !== "number" || !raw.gamma || !raw.phi) return null;
    return { ...raw, gamma: { ...raw.gamma, x: raw.gamma.gamma_mps2 }, phi: { ...raw.phi, x: raw.phi.phi_rad } } as unknown as Law;
}

/** Asks for the curves when set-point, friction or points have changed, and again while they are computed. */
export class LawReader {
    law: Law | null = null;
    private known = "";
    private asking = false;

    constructor(private readonly store: Store, private readonly reader: Reader) {}

    follow(): void {
        const { state } = this.store;
        if (!state || this.asking) return;
        const { frequency_hz, gamma_mps2, rho, phi_rad } = state.drive;
        const wanted = JSON.stringify([frequency_hz, gamma_mps2, rho, phi_rad, state.result.mu, state.points.length]);
        if (wanted === this.known) return;
        this.asking = true;
        void this.reader.json("api/law").then((answer) => {
            this.asking = false;
            if (answer === null || (answer as { pending?: boolean }).pending) return;
            this.law = lawOf(answer);
            this.known = wanted;
        });
    }
}
