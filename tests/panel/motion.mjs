// The walker of the simulated bench: Coulomb friction on a biharmonic base, by time steps; the closed form without stick.
export const g = 9.8;

const baseAcceleration = ({ gamma, rho, phi }, p) => gamma * (rho * Math.sin(p) + (1 - rho) * Math.sin(2 * p + phi));
const baseVelocity = ({ gamma, rho, phi, omega }, p) =>
    (-gamma / omega) * (rho * Math.cos(p) + ((1 - rho) / 2) * Math.cos(2 * p + phi));

/** One period after 60 to settle: {x, v, vB} at `bins` phases and the drift a period, all SI. */
export function steadyPeriod(drive, mu, bins = 100, steps = 4000) {
    const d = { gamma: drive.gamma_mps2, rho: drive.rho, phi: drive.phi_rad, omega: 2 * Math.PI * drive.frequency_hz };
    const period = 1 / drive.frequency_hz, dt = period / steps, most = mu * g * dt;
    let v = 0, x = 0;
    const turn = (each) => {
        x = 0;
        for (let k = 0; k < steps; k++) {
            each?.(k);
            const relative = v - baseVelocity(d, (2 * Math.PI * (k + 1)) / steps);
            v -= Math.sign(relative) * Math.min(most, Math.abs(relative));
            x += v * dt;
        }
    };
    for (let k = 0; k < 60; k++) turn();
    const out = { x: [], v: [], vB: [], aB: [], drift: 0, period };
    turn((k) => {
        if (k % (steps / bins)) return;
        const p = (2 * Math.PI * k) / steps;
        out.x.push(x);
        out.v.push(v);
        out.vB.push(baseVelocity(d, p));
        out.aB.push(baseAcceleration(d, p));
    });
    out.drift = x;
    return out;
}

/** v_D of a walker that never sticks; null when the closed form does not exist. */
export function closedForm(drive, mu) {
    const omega = 2 * Math.PI * drive.frequency_hz;
    const argument = (Math.PI * mu * g) / (2 * drive.rho * drive.gamma_mps2);
    if (argument > 1) return null;
    const start = Math.acos(argument);
    // v_B(t0 + T/2) - v_B(t0) = mu g T/2 while the first harmonic accelerates.
    return ((-drive.gamma_mps2 / omega) * (1 - drive.rho) * Math.cos(2 * start + drive.phi_rad)) / 2;
}

/** The answer of /api/law, of a few values: at the error of mu the exact law is taken for the closed form's. */
export function lawCurves(drive, { value, sigma }) {
    const curve = (name, xs) => {
        const values = (of) => {
            const sides = xs.map((x) => [value - sigma, value, value + sigma].map((mu) => of({ ...drive, [name]: x }, mu)));
            return { at_mu: sides.map((v) => v[1]), low: sides.map((v) => (v.includes(null) ? null : Math.min(...v))), high: sides.map((v) => (v.includes(null) ? null : Math.max(...v))) };
        };
        const exact = (d, mu) => (d.gamma_mps2 === 0 ? 0 : steadyPeriod(d, mu, 100, 200).drift * d.frequency_hz);
        return { [name]: xs, exact_mps: values(exact), closed_form_mps: values(closedForm) };
    };
    const steps = (from, to, n) => Array.from({ length: n }, (_, i) => from + ((to - from) * i) / (n - 1));
    return {
        mu: value, sigma, gamma_mps2: drive.gamma_mps2, phi_rad: drive.phi_rad,
        gamma: curve("gamma_mps2", steps(0, 3 * g, 25)), phi: curve("phi_rad", steps(-Math.PI, Math.PI, 37)),
    };
}

export { baseAcceleration };
