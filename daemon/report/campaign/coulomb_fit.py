"""mu by the exact Coulomb law, fitted to all points of a campaign at their measured drives: mu_ac.

The walker pushes the base back: a_B = S - k a_walker, with k = mass of the walker / mass that moves with the base. S has the
measured harmonics only; the push has all, because it jumps where a slip ends. In the frame of the base the push is a larger
friction coefficient and a larger tilt: the walker drifts as on the base S with mu (1 + k) and tilt (1 + k), exactly. So

  S_q = measured_q + k / (1 + k) a'_q        (a': acceleration of the walker on S, q as measured)
  measured_q = -(k / (1 + k) + c / q^2) a'_q for q >= 9, where the drive has nothing; c: suspension of the base

Free: mu, the tilt of the base (mirror partners show it) and k.
"""
import dataclasses

import numpy as np

from coulomb_law import G, Drives, settle

DAMPING = 0.79       # S follows mu: full steps overshoot
TURNS = 9            # of the fit; each solves the law once
PUSH_FROM = 9        # harmonics from here on are the walker's push alone
CLOSE = 3e-7         # change of mu that ends the fit
NODES, WEIGHTS = np.polynomial.legendre.leggauss(48)


@dataclasses.dataclass
class LawFit:
    mu: float
    mu_error: float      # of the scatter, and of gamma and phi when their errors are common to all points
    scatter: float       # the first part alone
    tilt: float          # rad; NaN: not fitted, the points have no mirror partners
    tilt_error: float
    push: float          # k; 0: not fitted
    chi2: float          # sum of squares over its degrees of freedom
    rows: np.ndarray     # points of the campaign that were fitted
    law: np.ndarray      # v_D of the law at these points, m/s
    z: np.ndarray        # (measured - law) / error
    note: str

    @property
    def known(self):
        return np.isfinite(self.mu)


def nothing(note):
    e = np.empty(0)
    return LawFit(np.nan, np.nan, np.nan, np.nan, np.nan, 0.0, np.nan, e.astype(int), e, e, note)


def walker_harmonics(drives, motion, mu, tilt):
    """Harmonics drives.q of the walker's acceleration, (B, Q) complex: A exp(i alpha) of A sin(2 pi q u + alpha)."""
    row, u, s, end = [], [], [], []
    for k, events in enumerate(motion.events):
        for j, (u0, _, state) in enumerate(events):
            row.append(k), u.append(u0), s.append(state)
            end.append(events[j + 1][0] if j + 1 < len(events) else 1.0)
    row, u, s, end = np.array(row, int), np.array(u), np.array(s), np.array(end)
    turn = -2j * np.pi * drives.q
    part = np.zeros((len(row), len(drives.q)), complex)
    slip = s != 0
    force = G * np.sin(tilt) - s[slip] * mu * G * np.cos(tilt)
    part[slip] = force[:, None] * (np.exp(np.outer(end[slip], turn)) - np.exp(np.outer(u[slip], turn))) / turn
    rest = np.flatnonzero(~slip)
    half = (end[rest] - u[rest]) / 2
    nodes = ((end[rest] + u[rest]) / 2)[:, None] + half[:, None] * NODES
    for k, r in enumerate(rest):
        one = drives.part(np.full(len(NODES), row[r]))
        part[r] = half[k] * ((WEIGHTS * one.acceleration(nodes[k])) @ np.exp(np.outer(nodes[k], turn)))
    total = np.zeros((len(drives), len(drives.q)), complex)
    np.add.at(total, row, 2j * part)
    return total


def base_without_push(measured, motion_on, motion, mu, tilt, push):
    """The base S and the push k, from the measured base and the walker's motion on the last S."""
    complex_of = lambda d: d.amplitude * np.exp(1j * d.phase)
    walker, base = walker_harmonics(motion_on, motion, mu * (1 + push), tilt * (1 + push)), complex_of(measured)
    high = measured.q >= PUSH_FROM
    if high.sum() >= 4:
        a, b = walker[:, high], -base[:, high]
        columns = np.stack([a, a / measured.q[high]**2], -1).reshape(-1, 2)  # mass, and the suspension below it
        share = np.linalg.lstsq(np.concatenate([columns.real, columns.imag]),
                                np.concatenate([b.real.ravel(), b.imag.ravel()]), rcond=None)[0][0]  # k / (1 + k)
        push = float(share / (1 - share)) if 0 < share < 0.6 else 0.0
    S = base + push / (1 + push) * walker
    return Drives(measured.frequency, measured.q, np.abs(S), np.angle(S)), push


def fit_coulomb(campaign, v=None, start=0.113):
    """Fits mu_ac. v: drift velocities in place of the measured ones, e.g. the true ones."""
    p = campaign.points
    v = p["v_D"] if v is None else v
    good = campaign.measured & np.isfinite(v) & (p["v_D_errors"] > 0) & np.isfinite(p["frequency"])
    good &= np.isfinite(campaign.harmonics["amplitude"][:, :2]).all(1)
    rows = np.flatnonzero(good)
    if len(rows) < 3:
        return nothing(f"{len(rows)} measured points; at least 3 are needed")
    measured, v = campaign.drives(rows), v[rows]
    with_tilt = bool(np.isin(p["partner"][rows], p["point"][rows]).any())
    mu, tilt, push, S = start, 0.0, 0.0, measured
    note = ""
    for turn in range(TURNS):
        motion = settle(S, mu * (1 + push), tilt=tilt * (1 + push))
        if turn in (0, 3):
            slopes, common, sigma = derivatives(S, motion, mu, push, tilt, campaign, rows)
        use = motion.settled & np.isfinite(sigma)
        columns = [slopes[0], slopes[1]] if with_tilt else [slopes[0]]
        A = np.stack(columns, 1)[use] / sigma[use, None]
        left = (v - motion.v_D)[use] / sigma[use]
        covariance = np.linalg.pinv(A.T @ A)
        step = DAMPING * covariance @ A.T @ left
        if not np.isfinite(step).all() or not A[:, 0].any():
            return nothing("the points do not depend on mu")
        before, mu = mu, float(np.clip(mu + step[0], mu / 2, mu * 2))
        tilt += float(np.clip(step[1], -0.02, 0.02)) if with_tilt else 0.0
        S, push = base_without_push(measured, S, motion, before, tilt, push)
        if turn >= 3 and abs(mu - before) < CLOSE * mu:
            break
    else:
        note = "" if abs(mu - before) < 1e-5 * mu else "not converged"
    motion = settle(S, mu * (1 + push), tilt=tilt * (1 + push))
    z = (v - motion.v_D) / sigma
    error = np.sqrt(np.diag(covariance))
    shifts = [(covariance @ A.T @ (c[use] / sigma[use]))[0] for c in common]
    freedom = use.sum() - len(error)
    tilts = (tilt, error[1]) if with_tilt else (np.nan, np.nan)
    return LawFit(mu, np.hypot(error[0], np.linalg.norm(shifts)), error[0], *tilts, push,
                  float(np.sum(z[use]**2) / freedom) if freedom > 0 else np.nan, rows, motion.v_D, z, note)


def derivatives(S, motion, mu, push, tilt, campaign, rows):
    """(dv/dmu, dv/dtilt), the changes of v by a common error of gamma and of phi, and the error of each point: that of v_D
    with those of the measured gamma and phi."""
    scaled = Drives(S.frequency, S.q, S.amplitude * 1.0005, S.phase)
    turned = Drives(S.frequency, S.q, S.amplitude, S.phase + 0.0005 * (S.q == 2))
    change = lambda drives, m, t: settle(drives, m * (1 + push), tilt=t * (1 + push)).v_D - motion.v_D
    slopes = (change(S, mu * 1.001, tilt) / (mu * 0.001), change(S, mu, tilt + 2e-5) / 2e-5)
    by_gamma, by_phi = change(scaled, mu, tilt) / 0.0005, change(turned, mu, tilt) / 0.0005
    p = campaign.points
    d_gamma = np.nan_to_num(p["gamma_errors"][rows] / p["gamma"][rows])
    d_phi = np.nan_to_num(campaign.phi_errors[rows])
    common = by_gamma * np.median(d_gamma), by_phi * np.median(d_phi)
    return slopes, common, np.sqrt(p["v_D_errors"][rows]**2 + (by_gamma * d_gamma)**2 + (by_phi * d_phi)**2)
