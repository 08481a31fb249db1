"""The fits of the paper: cosines v* cos(phi - Theta*), null phases, mu_ns, the gamma of reversal; and its closed form.

Closed form (no stick), any rho:  kappa = pi mu g / (2 rho gamma),  Theta = 2 asin(kappa),  valid for kappa <= 1
  v_D = gamma (1 - rho) / (2 w) cos(phi - Theta)
"""
import dataclasses

import numpy as np

from coulomb_law import G, Drives, biharmonic, settle

NULL_RANGE = 0.36     # rad around the null phase
COSINE_PHASES = 6     # least number of phases of a cosine fit
LARGEST_GAP = 1.65    # rad between neighbouring phases of a cosine fit


def closed_theta(gamma, mu, rho=0.5):
    with np.errstate(divide="ignore", invalid="ignore"):
        kappa = np.pi * mu * G / (2 * rho * np.asarray(gamma, float))
        return 2 * np.arcsin(np.where(kappa <= 1, kappa, np.nan))


def closed_drift(gamma, phi, mu, rho=0.5, frequency=20.0):
    return gamma * (1 - rho) / (4 * np.pi * frequency) * np.cos(phi - closed_theta(gamma, mu, rho))


def coulomb_theta(gamma, mu, rho=0.5):
    """Null phase of the exact law less pi/2, rad. The frequency does not matter."""
    gamma = np.ravel(gamma).astype(float)
    low, high = np.full(len(gamma), np.pi / 2 - 0.1), np.full(len(gamma), np.pi / 2 + 2.2)
    value = [settle(biharmonic(gamma, phi, rho), mu).v_D for phi in (low, high)]
    valid = (value[0] > 1e-9) & (value[1] < -1e-9)
    side = np.zeros(len(gamma))
    for _ in range(22):  # Illinois
        with np.errstate(divide="ignore", invalid="ignore"):
            new = np.where(valid, (low * value[1] - high * value[0]) / (value[1] - value[0]), low)
        found = settle(biharmonic(gamma, new, rho), mu).v_D
        up = found > 0
        value = [np.where(up, found, np.where(side < 0, value[0] / 2, value[0])),
                 np.where(up, np.where(side > 0, value[1] / 2, value[1]), found)]
        low, high = np.where(up, new, low), np.where(up, high, new)
        side = np.where(up, 1, -1)
        if not valid.any() or np.max(np.abs(found[valid])) < 1e-10:
            break
    return np.where(valid, new - np.pi / 2, np.nan)


@dataclasses.dataclass
class Setting:
    """Points that differ in gamma and phi only."""
    frequency: float
    rho: float
    overtones: tuple   # ((q, share of gamma, sine phase), ...) at 0 <= phi < pi; a mirror partner has even ones reversed
    rows: np.ndarray   # measured points

    @property
    def like_the_paper(self):
        return abs(self.frequency - 20) < 0.1 and abs(self.rho - 0.5) < 0.005 and not self.overtones

    @property
    def words(self):
        extra = "".join(f", {100 * share:.2g} % of {q}f" for q, share, _ in self.overtones)
        return f"{self.frequency:.4g} Hz, rho {self.rho:.3g}{extra}"

    def drives(self, gamma, phi):
        """Drives as asked for; gamma and phi are broadcast together."""
        d = biharmonic(gamma, phi, self.rho, self.frequency)
        gamma = d.amplitude.sum(1)
        return Drives(d.frequency, np.array([1, 2, *(q for q, _, _ in self.overtones)]),
                      np.column_stack([d.amplitude, *(gamma * share for _, share, _ in self.overtones)]),
                      np.column_stack([d.phase, *(0 * gamma + phase for _, _, phase in self.overtones)]))


def settings_of(campaign):
    """Settings of the measured points; the one of the paper first, then those with the most points."""
    p, h, found = campaign.points, campaign.harmonics, {}
    for k in np.flatnonzero(campaign.measured):
        share = np.nan_to_num(h["asked_amplitude"][k] / p["asked_gamma"][k])
        mirror = np.mod(p["asked_phi"][k] + 1e-6, 2 * np.pi) >= np.pi
        overtones = tuple((int(q), round(s, 5), round(np.mod(phase + np.pi * (mirror and q % 2 == 0) + 1e-6, 2 * np.pi), 4))
                          for q, s, phase in zip(h["q"], share, np.nan_to_num(h["asked_phase"][k])) if q > 2 and s > 1e-6)
        found.setdefault((round(p["asked_frequency"][k], 4), round(p["asked_rho"][k], 4), overtones), []).append(k)
    settings = [Setting(*key, np.array(rows)) for key, rows in found.items()]
    return sorted(settings, key=lambda s: (not s.like_the_paper, -len(s.rows)))


def gammas_of(campaign, rows):
    """(asked gamma, rows) in rising order."""
    g = np.round(campaign.points["asked_gamma"][rows], 5)
    return [(value, rows[g == value]) for value in np.unique(g)]


@dataclasses.dataclass
class Cosine:
    gamma: float
    amplitude: float      # v*, m/s
    amplitude_error: float
    theta: float          # Theta*, rad
    theta_error: float
    chi2: float
    residual: float       # rms, m/s
    series: str
    rows: np.ndarray


def linear_fit(A, y, sigma):
    """Weighted least squares: values, covariance, chi2 over its degrees of freedom (NaN without any)."""
    sigma = np.broadcast_to(np.asarray(sigma, float), y.shape)
    W = A / sigma[:, None]
    covariance = np.linalg.pinv(W.T @ W)
    x = covariance @ W.T @ (y / sigma)
    freedom = len(y) - A.shape[1]
    return x, covariance, np.sum(((y - A @ x) / sigma)**2) / freedom if freedom > 0 else np.nan


def cosine_fits(campaign, setting, v):
    """v* cos(phi - Theta*) at each gamma; each series by itself, because others crowd around the null."""
    p, fits = campaign.points, []
    for series in dict.fromkeys(p["series"][setting.rows]):
        for gamma, rows in gammas_of(campaign, setting.rows[p["series"][setting.rows] == series]):
            rows = rows[np.isfinite(v[rows]) & (p["v_D_errors"][rows] > 0)]
            phases = np.unique(np.round(np.mod(p["asked_phi"][rows] + 1e-6, 2 * np.pi), 4))
            if len(phases) < COSINE_PHASES or np.max(np.diff([*phases, phases[0] + 2 * np.pi])) > LARGEST_GAP:
                continue
            phi = p["phi"][rows]
            A = np.stack([np.cos(phi), np.sin(phi)], 1)
            # All phases weigh the same, as in the paper: no cosine fits the data to within their errors.
            P, sigma = np.linalg.pinv(A), p["v_D_errors"][rows]
            (c, s), V = P @ v[rows], (P * sigma**2) @ P.T
            chi2 = np.sum(((v[rows] - A @ [c, s]) / sigma)**2) / (len(rows) - 2)
            a = np.hypot(c, s)
            along, across = np.array([c, s]) / a, np.array([-s, c]) / a**2
            fits.append(Cosine(gamma, a, np.sqrt(along @ V @ along), np.arctan2(s, c), np.sqrt(across @ V @ across), chi2,
                               np.sqrt(np.mean((v[rows] - A @ [c, s])**2)), series, rows))
    return fits


@dataclasses.dataclass
class Null:
    gamma: float
    phi: float
    error: float
    chi2: float
    points: int

    @property
    def theta(self):
        return self.phi - np.pi / 2


def null_phases(campaign, setting, v):
    """Phase of v_D = 0 with dv_D/dphi < 0 at each gamma, from the points within 0.36 rad and their mirror partners."""
    p, nulls = campaign.points, []
    for gamma, rows in gammas_of(campaign, setting.rows):
        rows = rows[np.isfinite(v[rows]) & (p["v_D_errors"][rows] > 0)]
        # The falling null is in 0.9 .. 0.9 + pi. A mirror partner, at phi + pi, drifts with -v_D.
        phi = np.mod(p["phi"][rows] - 0.9, 2 * np.pi) + 0.9
        side = np.where(phi > 0.9 + np.pi, -1.0, 1.0)
        phi, w = np.where(side < 0, phi - np.pi, phi), side * v[rows]
        order = np.argsort(phi)
        phi, w, side, sigma = phi[order], w[order], side[order], p["v_D_errors"][rows][order]
        crossing = [k for k in range(len(phi) - 1) if w[k] > 0 >= w[k + 1] and phi[k + 1] - phi[k] < 0.8]
        if not crossing:
            continue
        k = crossing[0]
        start = phi[k] + (phi[k + 1] - phi[k]) * w[k] / (w[k] - w[k + 1])
        near = np.abs(phi - start) < NULL_RANGE
        noise = np.median(np.nan_to_num(campaign.phi_errors[rows]))
        null = root_of(phi[near] - start, w[near], side[near], sigma[near], noise)
        if null:
            nulls.append(Null(gamma, start + null[0], *null[1:], int(near.sum())))
    return nulls


def root_of(x, w, side, sigma, noise):
    """(root, error, chi2) of the polynomial of the lowest degree from 1 to 3 that fits, or None.
    side: +1 or -1 for a mirror partner; noise: error of x."""
    different, found = len(np.unique(np.round(x, 3))), None
    for degree in range(1, min(3, different - 1) + 1):
        A = np.stack([x**n for n in range(degree + 1)], 1)
        if len(np.unique(side)) > 1 and len(x) > degree + 2:
            A = np.concatenate([A, side[:, None]], 1)  # drift by a tilt: the same sign for both partners
        c, V, chi2 = linear_fit(A, w, np.hypot(sigma, noise * np.ptp(w) / max(np.ptp(x), 1e-9)))
        roots = np.roots(c[degree::-1])
        real = roots.real[np.abs(roots.imag) < 1e-9]
        if not len(real) or np.min(np.abs(real)) > NULL_RANGE:
            continue
        root = real[np.argmin(np.abs(real))]
        row = np.zeros(A.shape[1])
        row[:degree + 1] = root**np.arange(degree + 1)
        slope = np.sum(c[1:degree + 1] * np.arange(1, degree + 1) * root**np.arange(degree))
        found = root, np.sqrt(row @ V @ row) / abs(slope), chi2
        if chi2 < 3:
            break
    return found if different > 2 else None


def student_95(freedom):
    """Quantile of Student's t for a two-sided 95 % interval."""
    table = {1: 12.706, 2: 4.303, 3: 3.182, 4: 2.776, 5: 2.571, 6: 2.447, 7: 2.365, 8: 2.306, 9: 2.262, 10: 2.228}
    return table.get(freedom, 1.96 + 2.6 / freedom) if freedom > 0 else np.nan


def mu_no_stick(nulls, rho):
    """(mu, half width of its 95 % interval, rms misfit of Theta) as in the paper: all null phases weigh the same."""
    use = [n for n in nulls if n.theta > 0]
    if len(use) < 2:
        return np.nan, np.nan, np.nan
    gamma, theta = np.array([n.gamma for n in use]), np.array([n.theta for n in use])
    scale = np.pi * G / (2 * rho * gamma)
    mu = np.median(np.sin(theta / 2) / scale)
    for _ in range(50):
        kappa = np.clip(mu * scale, 0, 0.9999)
        slope = 2 * scale / np.sqrt(1 - kappa**2)
        left = theta - 2 * np.arcsin(kappa)
        step = slope @ left / (slope @ slope)
        mu += np.clip(step, -0.1 * mu, 0.1 * mu)
        if abs(step) < 1e-12:
            break
    freedom = len(use) - 1
    return mu, student_95(freedom) * np.sqrt(left @ left / freedom / (slope @ slope)), np.sqrt(np.mean(left**2))


def reversal(campaign, setting, v, phi, law):
    """(gamma, error) at which v_D changes its sign at phi, m/s^2. law(gamma): v_D, for the shape between the points."""
    p = campaign.points
    rows = setting.rows[near_phase(p["asked_phi"][setting.rows], phi) & np.isfinite(v[setting.rows])]
    rows = rows[np.argsort(p["gamma"][rows])]
    g, w = p["gamma"][rows], v[rows]
    crossing = np.flatnonzero((w[:-1] > 0) & (w[1:] <= 0))
    if not len(crossing):
        return np.nan, np.nan
    k = crossing[0]
    fine = np.linspace(g[k], g[k + 1], 200)
    shape = law(fine)
    if not np.isfinite(shape).all():
        shape = np.zeros(len(fine))
    share = (fine - g[k]) / (g[k + 1] - g[k])
    curve = shape + (w[k] - shape[0]) * (1 - share) + (w[k + 1] - shape[-1]) * share
    j = np.flatnonzero((curve[:-1] > 0) & (curve[1:] <= 0))[0]
    t = curve[j] / (curve[j] - curve[j + 1])
    slope = (curve[j + 1] - curve[j]) / (fine[1] - fine[0])
    e = np.nan_to_num(p["v_D_errors"][rows])
    return fine[j] + t * (fine[1] - fine[0]), np.hypot(e[k] * (1 - share[j]), e[k + 1] * share[j]) / abs(slope)


def near_phase(phi, wanted, tolerance=0.01):
    return np.abs(np.angle(np.exp(1j * (np.asarray(phi) - wanted)))) < tolerance
