"""Friction against the velocity of slip, without a law, beside the law that describes v_D."""
import matplotlib.pyplot as plt
import numpy as np

from drawing import Missing, colour_of, plain, points


def mu_of_law(law, v, gravity):
    """mu of steady slip at velocities v (m/s)."""
    f, speed = law.friction, np.abs(v)
    shape = np.where(v < 0, f.get("backward", 1), 1) * (1 + f.get("log_share", 0) * np.log1p(speed / 1e-3))
    if "stribeck" in f:
        shape = 1 + (law.static - 1) * np.exp(-(speed / f["stribeck"]) ** 2)
    return law.mu * shape + f.get("viscous", 0) * speed / gravity


def fig_friction(sources):
    known = list({id(s.analysis): s for s in sources if len(s.analysis.fits.friction)}.values())
    if not known:
        raise Missing("it needs the fits of 'shakerd mu' with slips of 6 frames or more between their kinks.")
    figure, axes = plt.subplots(figsize=(6.4, 3))
    for k, s in enumerate(known):
        v, mu, error = s.analysis.fits.friction.T
        points(axes, 1e3 * v, mu, error, colour_of(k), s.marker, k == 0, plain(s.campaign.label))
        for sign in (-1, 1) if s.law.mu_name and not s.law.refused else ():
            line = sign * np.linspace(0, np.max(np.abs(v)), 200)
            axes.plot(1e3 * line, mu_of_law(s.law, line, s.setting.gravity), color=colour_of(k), lw=1)
    axes.axvline(0, color="0.5", lw=0.6)
    axes.set(xlabel="$v_R$ (mm/s)", ylabel="mu")
    axes.legend(loc="upper center", fontsize=6.5)
    return figure
