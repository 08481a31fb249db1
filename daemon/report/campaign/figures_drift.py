"""Figs. 2(b), 3(a), 3(b), 4, and the residuals of Coulomb's law.

Lines: the law of the source on the drive as asked for, its band +-2 errors of mu. Dashed: the closed form."""
import matplotlib.pyplot as plt
import numpy as np

from drawing import PAPER, REFUSED, Missing, angle_name, band, colour_of, key, plain, points, with_error
from fits import MU_PAPER
from paper_numbers import PAPER_COSINES
from sources import folded, gamma_range, phases_with_gammas
from walker_law import G, closed_drift, closed_theta

CLOSED = (0, (4, 2))
PHI = np.linspace(0, 2 * np.pi, 121)


def fig_2b(sources):
    """v_D against gamma at several phases."""
    phases = phases_with_gammas(sources)
    if not phases:
        raise Missing("it needs points at three gammas or more at one phase.")
    figure, axes = plt.subplots()
    gamma = gamma_range(sources)
    for k, phi in enumerate(phases):
        for s in sources:
            draw_drift(axes, s, phi, colour_of(k), lambda v, rows: 1e3 * v, "v_D_errors", 1e3)
            if s.curves:
                band(axes, gamma / G, *(1e3 * v for v in s.law_drift(gamma, phi)), colour_of(k), s.line)
        s0 = sources[0].setting
        closed = closed_drift(gamma, phi, sources[0].law.mu, s0.rho, s0.frequency, s0.gravity)
        axes.plot(gamma / G, 1e3 * closed, color=colour_of(k), ls=CLOSED, lw=0.7, alpha=0.7)
    axes.axhline(0, color="0.5", lw=0.6)
    axes.set(xlabel="γ / g", ylabel="$v_D$ (mm/s)")
    bottom, top = axes.get_ylim()
    axes.set_ylim(bottom - (top - bottom) * 0.05 * (len(sources) + sum(s.curves for s in sources) - 2), top)  # for the legend
    phase_key(axes, phases, "upper left")
    look_key(axes, sources, "lower left")
    return figure


def draw_drift(axes, source, phi, colour, value, errors, unit):
    """The points of a source at phi (filled) and at phi + pi with the sign changed (open)."""
    rows = source.setting.rows
    at, v, direct = folded(source, rows)
    for filled in (True, False):
        use = (np.abs(at - phi) < 0.003) & (direct == filled)
        if use.any():
            points(axes, source.column("gamma", rows[use]) / G, value(v[use], rows[use]),
                   unit * source.column(errors, rows[use]), colour, source.marker, filled)


def phase_key(axes, phases, loc):
    key(axes, [(f"φ = {angle_name(phi)}", {"color": colour_of(k), "lw": 2}) for k, phi in enumerate(phases)], loc=loc)


def look_key(axes, sources, loc, closed="closed form", mirror="at φ + π, sign changed", more=()):
    entries = [(s.label, {"marker": s.marker}) for s in sources]
    if mirror:
        entries.append((mirror, {"marker": sources[0].marker, "mfc": "white"}))
    entries += [(s.law_words, {"lw": 1.2, "ls": s.line}) for s in sources if s.curves]
    if closed:
        entries.append((closed, {"lw": 0.7, "ls": CLOSED}))
    key(axes, entries + list(more), loc=loc)


def circle_gammas(sources, most=5):
    """Gammas of Fig. 3(a): those with the most points around the circle."""
    count = {}
    for s in sources:
        for gamma, rows in s.circles.items():
            count[gamma] = max(len(rows), count.get(gamma, 0))
    gammas = sorted(g for g in count if count[g] >= 0.75 * max(count.values()))
    return [gammas[k] for k in np.unique(np.linspace(0, len(gammas) - 1, min(most, len(gammas))).round().astype(int))]


def fig_3a(sources):
    """v_D against phi at several gammas, with the cosines of the paper."""
    gammas = circle_gammas(sources)
    if not gammas:
        raise Missing("it needs six phases or more around the circle at one gamma.")
    figure, axes = plt.subplots()
    for k, gamma in enumerate(gammas):
        for s in sources:
            rows = s.circles.get(gamma)
            if rows is not None:
                phi = np.mod(s.column("phi", rows) + 0.05, 2 * np.pi) - 0.05
                points(axes, phi, 1e3 * s.column("v_D", rows), 1e3 * s.column("v_D_errors", rows), colour_of(k), s.marker,
                       s is sources[0])
            if s.curves:
                band(axes, PHI, *(1e3 * v for v in s.law_drift(gamma, PHI)), colour_of(k), s.line)
        paper = PAPER_COSINES.get(round(gamma / G, 3))
        for v, theta, line in [(*ours, CLOSED) for ours in cosines(sources[0], gamma)] + ([(*paper, ":")] if paper else []):
            axes.plot(PHI, 1e3 * v * np.cos(PHI - theta), color=colour_of(k), ls=line, lw=0.8, alpha=0.8)
    axes.axhline(0, color="0.5", lw=0.6)
    axes.set(xlabel="φ (rad)", ylabel="$v_D$ (mm/s)", xlim=(-0.1, 2 * np.pi + 0.1))
    axes.set_xticks(np.arange(5) * np.pi / 2, ["0", "π/2", "π", "3π/2", "2π"])
    key(axes, [(f"γ = {g / G:.3g} g", {"color": colour_of(k), "lw": 2}) for k, g in enumerate(gammas)], loc="lower right")
    bottom, top = axes.get_ylim()
    axes.set_ylim(bottom - 0.1 * (top - bottom), top + 0.25 * (top - bottom))  # for the legends
    of_paper = any(round(g / G, 3) in PAPER_COSINES for g in gammas)
    look_key(axes, sources, "upper center", "fit $v_D^*$ cos(φ − Θ*)", "",
             [("fits of the paper", {"ls": ":", "lw": 0.9})] if of_paper else [])
    return figure


def cosines(source, gamma):
    """(v_D*, Theta*) of the fit with the most points at this gamma; empty without one."""
    pairs = [(v.value, theta.value, v.points) for v in source.fits("v_D*") for theta in source.fits("Theta*")
             if v.series == theta.series and v.gamma == theta.gamma and abs(v.gamma - gamma) < 1e-3]
    return [max(pairs, key=lambda p: p[2])[:2]] if pairs else []


def fig_3b(sources):
    """Theta = phi_0 - pi/2 against gamma, with the fit of the closed form."""
    with_nulls = [s for s in sources if s.fits("phi_0")]
    if not with_nulls:
        raise Missing("it needs null phases from the fits of 'shakerd mu', hence points on both sides of a null.")
    figure, axes = plt.subplots()
    top = max(n.gamma for s in with_nulls for n in s.fits("phi_0"))
    gamma = np.linspace(0.3 * G, max(top * 1.05, 0.5 * G), 60)
    band(axes, gamma / G, *(closed_theta(gamma, m) for m in (MU_PAPER, MU_PAPER - 0.006, MU_PAPER + 0.006)), PAPER, ":",
         "closed form, mu = 0.113(6): the paper")
    for k, s in enumerate(with_nulls):
        g, theta, error = np.array([(n.gamma, n.theta, n.error) for n in s.fits("phi_0")]).T
        points(axes, g / G, theta, error, colour_of(k), s.marker, True, s.label)
        if s.curves:
            band(axes, gamma / G, *s.law_null(gamma), colour_of(k), REFUSED if s.law.refused else "-", s.law_words)
        fit = s.analysis.fits.one("mu_ns")
        if s.curves and np.isfinite(fit.value):
            m, two = fit.value, 2 * np.nan_to_num(s.analysis.fits.total_error("mu_ns"))
            closed = [closed_theta(gamma, x, s.setting.rho, s.setting.gravity) for x in (m, m - two, m + two)]
            band(axes, gamma / G, *closed, colour_of(k), CLOSED,
                 f"closed form, mu_ns = {with_error(m, two / 2)}", 0.8)
    axes.set(xlabel="γ / g", ylabel="Θ = $φ_0$ − π/2 (rad)", ylim=(0, None))
    axes.legend(loc="upper right")
    return figure


def fig_4(sources):
    """Efficiency |v_D| / V_RMS against gamma; closed form with the mu of the paper, as there."""
    phases = phases_with_gammas(sources)
    if not phases:
        raise Missing("it needs points at three gammas or more at one phase.")
    figure, axes = plt.subplots()
    gamma = gamma_range(sources)
    s0 = sources[0].setting
    rms = lambda s: gamma * np.sqrt((4 * s.rho**2 + (1 - s.rho)**2) / 8) / (2 * np.pi * s.frequency)
    for k, phi in enumerate(phases):
        for s in sources:
            draw_drift(axes, s, phi, colour_of(k), lambda v, rows: s.column("efficiency", rows), "efficiency_errors", 1)
            if s.curves and not s.setting.overtones:
                band(axes, gamma / G, *(np.abs(v) / rms(s.setting) for v in s.law_drift(gamma, phi)), colour_of(k), s.line)
        closed = np.abs(closed_drift(gamma, phi, MU_PAPER, s0.rho, s0.frequency)) / rms(s0)
        axes.plot(gamma / G, closed, color=colour_of(k), ls=CLOSED, lw=0.7, alpha=0.7)
    axes.axhline(0.5, color=PAPER, ls=":", lw=0.9)
    axes.set(xlabel="γ / g", ylabel="η = |$v_D$| / $V_{RMS}$", ylim=(0, None))
    axes.set_ylim(0, axes.get_ylim()[1] * (1.15 + 0.08 * (len(sources) + sum(s.curves for s in sources))))  # for the legend
    key(axes, [(f"φ = {angle_name(phi)}", {"color": colour_of(k), "lw": 2}) for k, phi in enumerate(phases)], loc="upper left",
        ncol=1 + len(phases) // 5)
    look_key(axes, sources, "upper right", "closed form, mu = 0.113", "at φ + π",
             [("the paper: up to about 0.50", {"lw": 0.9, "ls": ":", "color": PAPER})])
    return figure


def fig_residuals(sources):
    """Measured v_D less Coulomb's law with mu_ac at the measured drive with the walker's push."""
    fitted = list({id(s.analysis): s for s in sources if len(s.analysis.fits.rows)}.values())
    if not fitted:
        raise Missing("it needs mu_ac from the fits of 'shakerd mu', hence three moving points or more.")
    figure, axes = plt.subplots(figsize=(6.4, 3))
    for k, s in enumerate(fitted):
        fits, p = s.analysis.fits, s.campaign.points
        left = p["v_D"][fits.rows] - fits.law
        with np.errstate(divide="ignore", invalid="ignore"):
            error = left / fits.z
        points(axes, p["gamma"][fits.rows] / G, 1e6 * left, 1e6 * error, colour_of(k), s.marker, k == 0,
               f"{plain(s.campaign.label)}: chi2 {fits.one('mu_ac').chi2:.2f}, {np.sum(np.abs(fits.z) > 3)} of {len(fits.z)}"
               " beyond 3 errors")
    axes.axhline(0, color="0.3", lw=0.8)
    axes.set(xlabel="γ / g", ylabel="$v_D$ − Coulomb's law (µm/s)")
    left, right = axes.get_xlim()
    axes.set_xlim(left - 0.05, right + 0.05)
    axes.legend(loc="upper left", fontsize=6.5)
    return figure
