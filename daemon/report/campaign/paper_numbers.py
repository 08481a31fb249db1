"""The paper beside us: each number that the paper states, ours from the points and the fits, and the truth of a simulated bench.

The truth of a quantity of v_D is the same computation with the true v_D; that of mu_ac, mu_k and of an event is the scene's. A
cosine and mu_ns, which are the law of no walker, have none.
"""
import dataclasses

import numpy as np

from fits import MU_PAPER, Fits, fits_for
from settings import near_phase, settings_of
from walker_law import G, Law, settle, stick_intervals

PAPER_COSINES = {0.68: (8.3e-3, 1.12), 1.0: (17.6e-3, 0.62), 3.0: (38.7e-3, 0.22)}


@dataclasses.dataclass
class Row:
    quantity: str
    paper: str           # as the paper states it
    paper_value: float   # NaN: the paper gives no number
    ours: float
    error: float         # standard error; NaN: not known
    truth: float         # NaN: not a simulated bench, or not known
    unit: str = ""
    note: str = ""
    comparable: bool = True  # with other campaigns; False: depends on which points were measured

    @property
    def z(self):
        return (self.ours - self.truth) / self.error if self.error > 0 else np.nan

    @property
    def to_paper(self):
        return self.ours / self.paper_value - 1 if self.paper_value else np.nan


@dataclasses.dataclass
class Analysis:
    """Results of one campaign that figures and tables share."""
    campaign: object
    settings: list      # see settings_of
    fits: Fits          # those at one gamma or phase are of settings[0]
    law: Law            # of the curves


def analyse(campaign, given):
    """given: fits of the campaign, an object of `shakerd mu --json`; empty: none."""
    fits = fits_for(campaign, given)
    return Analysis(campaign, settings_of(campaign), fits, fits.law_of_curves())


def find(campaign, setting, gamma, phi):
    """Measured point next to a set-point (gamma in g), or None."""
    p = campaign.points
    near = near_phase(p["asked_phi"][setting.rows], phi) & (np.abs(p["asked_gamma"][setting.rows] / G - gamma) < 0.01)
    return setting.rows[near][0] if near.any() else None


def paper_rows(analysis):
    """The table, for the first setting of a campaign; empty without points."""
    if not analysis.settings:
        return []
    c, s = analysis.campaign, analysis.settings[0]
    return [*mu_rows(analysis), *cosine_rows(analysis), *ratio_rows(c, s), *event_rows(analysis), *reversal_rows(analysis),
            *efficiency_rows(c, s), *no_stick_rows(analysis)]


def mu_rows(a):
    rows, true = [], a.campaign.truth("mu_k")
    for name, words, paper, of in (("mu_ns", "no-stick form", "0.113(6)", "null phases"),
                                   ("mu_ac", "exact Coulomb law", "0.113(6)", "points"),
                                   ("mu_k", "slopes of v(t) in slips", "", "slips")):
        fit = a.fits.one(name)
        if np.isfinite(fit.value):
            note = f"{fit.points:.0f} {of}; error of these alone {fit.error:.1g}"
            rows.append(Row(f"{name}: {words}", paper, MU_PAPER if paper else np.nan, fit.value, a.fits.total_error(name),
                            np.nan if name == "mu_ns" else true, "", note))
    return rows


def cosine_rows(a):
    rows = []
    for name, paper, scale, unit, k in (("v_D*", "{:g} mm/s", 1e3, "mm/s", 0), ("Theta*", "{:g}", 1, "rad", 1)):
        for gamma, values in PAPER_COSINES.items():
            fits = [f for f in a.fits.named(name) if abs(f.gamma / G - gamma) < 0.01]
            if fits:
                f, value = max(fits, key=lambda f: f.points), scale * values[k]
                rows.append(Row(f"{name} at {gamma:g} g", paper.format(value), value, scale * f.value, scale * f.error,
                                scale * f.truth, unit, f"series {f.series}, {f.points:.0f} points", False))
    return rows


def ratio_rows(c, s):
    rows, p = [], c.points
    for phi, name, paper, words in ((0, "0", 8, "nearly 8"), (np.pi / 2, "pi/2", 2, "doubles")):
        low, high = find(c, s, 0.5, phi), find(c, s, 2, phi)
        if low is not None and high is not None:
            ratio = lambda v: v[high] / v[low]
            part = [p["v_D_errors"][k] / p["v_D"][k] for k in (low, high)]
            rows.append(Row(f"v_D(2 g) / v_D(0.5 g) at phi = {name}", words, paper, ratio(p["v_D"]),
                            abs(ratio(p["v_D"])) * np.hypot(*part), ratio(p["true_v_D"])))
    low, high = find(c, s, 2, np.pi / 2), find(c, s, 3, np.pi / 2)
    if low is not None and high is not None:
        v, e = p["v_D"], p["v_D_errors"]
        rows.append(Row("v_D(3 g) / v_D(2 g) at phi = pi/2", "saturates", np.nan, v[high] / v[low],
                        abs(v[high] / v[low]) * np.hypot(e[low] / v[low], e[high] / v[high]),
                        p["true_v_D"][high] / p["true_v_D"][low]))
    return rows


def true_motion(c, rows):
    """Settled motion of the scene's walker on the measured base; None: the scene is not known, or its law is not Coulomb's."""
    walker = {"law": "coulomb", "viscous_per_s": 0, "backward_ratio": 1, **c.scene.get("walker", {})}
    coulomb = (walker["law"], walker["viscous_per_s"], walker["backward_ratio"]) == ("coulomb", 0, 1)
    if not (coulomb and np.isfinite(c.truth("mu_k"))):
        return None
    # The push of the walker above the measured harmonics moves no event by more than 0.001 T.
    return settle(c.drives(rows), c.truth("mu_k"), c.truth("mu_s"), np.nan_to_num(c.truth("tilt")))


def measured_stick(c, row, near):
    """(from, to, error) of the interval next to `near`, averaged over the passes; None without any."""
    t = c.stick
    mine = (t["point"] == c.points["point"][row]) & np.isfinite(t["from"]) & np.isfinite(t["to"])
    middle = (t["from"] + t["to"]) / 2
    use = np.flatnonzero(mine & (np.abs(middle - near) < 0.1))
    if not len(use):
        return None
    return t["from"][use].mean(), t["to"][use].mean(), np.sqrt(np.mean(t["errors"][use]**2) / len(use))


def event_rows(a):
    c, s, rows = a.campaign, a.settings[0], []
    row = find(c, s, 0.5, 0)
    if row is not None:
        v, base, u = (c.cycle[k] if k == "phase" else c.cycle[k][row] for k in ("v", "v_base", "phase"))
        relative, error = v - base, c.cycle["v_errors"][row]
        k = np.flatnonzero((relative[:-1] > 0) & (relative[1:] <= 0) & (u[:-1] < 0.4))
        if len(k):
            drop = relative[k[0]] - relative[k[0] + 1]
            motion = true_motion(c, [row])
            true = [u for u, slip in motion.events[0] if slip == -1 and 0 < u < 0.4] if motion else []
            rows.append(Row("v_R = 0 at 0.5 g, phi = 0 (Fig. 2c)", "about 0.15 T", 0.15,
                            u[k[0]] + relative[k[0]] / drop * (u[1] - u[0]), error[k[0]] / drop * (u[1] - u[0]),
                            true[0] if true else np.nan, "T", ""))
    for gamma, phi, name, ends in ((0.5, 0, "0.5 g, phi = 0 (Fig. 2c)", (0.5, 0.7)),
                                   (2, np.pi / 2, "2 g, phi = pi/2 (Fig. 2d)", (0.24, 0.28))):
        row = find(c, s, gamma, phi)
        found = measured_stick(c, row, sum(ends) / 2) if row is not None else None
        if found:
            motion = true_motion(c, [row])
            true = [i for i in stick_intervals(motion, 0) if abs(sum(i) - sum(ends)) < 0.2] if motion else []
            for j, end in enumerate(("begins", "ends")):
                rows.append(Row(f"stick {end}, {name}", f"about {ends[j]:g} T", ends[j], found[j], found[2],
                                true[0][j] if true else np.nan, "T"))
    return rows + gone_rows(c, s)


def gone_rows(c, s):
    """Largest gamma with a stick interval at phi = 0."""
    p, rows = c.points, s.rows[near_phase(c.points["asked_phi"][s.rows], 0)]
    has = np.array([np.any(c.stick["point"] == p["point"][k]) for k in rows], bool)
    if not has.any() or has.all():
        return []
    last, without = p["gamma"][rows][has].max() / G, p["gamma"][rows][~has] / G
    after = without[without > last]
    note = f"the next gamma without one is {after.min():.4g} g" if len(after) else "no larger gamma was measured"
    motion, true = true_motion(c, rows), np.nan
    if motion:
        resting = [bool(stick_intervals(motion, k)) for k in range(len(rows))]
        true = p["gamma"][rows][resting].max() / G if any(resting) else np.nan
    return [Row("last gamma with a stick interval, phi = 0", "below g", np.nan, last, np.nan, true, "g", note)]


def reversal_rows(a):
    fits = [f for f in a.fits.named("gamma of reversal") if near_phase(f.phi, 3 * np.pi / 4, 0.003)]
    return [Row("v_D reverses at phi = 3 pi/4, gamma", "reverses", np.nan, f.value / G, f.error / G, f.truth / G, "g", f.note)
            for f in fits[:1]]


def efficiency_rows(c, s):
    p = c.points
    rows = s.rows[np.isfinite(p["efficiency"][s.rows])]
    if not len(rows):
        return []
    k = rows[np.argmax(p["efficiency"][rows])]
    where = f"at {p['gamma'][k] / G:.3g} g, phi = {np.degrees(p['phi'][k]):.3g} deg"
    ratio = p["v_rms"][k] * 2 * np.pi * p["frequency"][k] / p["gamma"][k]
    return [Row("largest efficiency", "about 0.50", 0.5, p["efficiency"][k], p["efficiency_errors"][k],
                abs(p["true_v_D"][k]) / p["v_rms"][k], "", where, False),
            Row("V_RMS w / gamma", "sqrt(5/32)", np.sqrt(5 / 32), ratio, np.nan, np.nan, "", where, False)]


def no_stick_rows(a):
    fits = [f for f in a.fits.named("v_D*") if f.gamma > 0.67 * G]
    if not fits:
        return []
    w, rho = 2 * np.pi * a.settings[0].frequency, a.settings[0].rho
    above = lambda v: np.array([f.gamma * (1 - rho) / (2 * w) / v(f) for f in fits])
    ours, error = above(lambda f: f.value), [f.error / f.value for f in fits]
    return [Row("no-stick amplitude gamma (1 - rho) / 2 w over v_D*, mean", "about 1.3", 1.3, ours.mean(),
                np.linalg.norm(ours * error) / len(fits), above(lambda f: f.truth).mean(), "",
                f"{len(fits)} fits from 0.68 g on: {ours.min():.3f} to {ours.max():.3f}; the paper's own fits give 1.60, 1.11,"
                " 1.51", False)]
