"""Friction against the velocity of slip, without a law, beside the law that describes v_D."""
import matplotlib.pyplot as plt
import numpy as np

from campaign_file import number
from drawing import Missing, colour_of, plain, points


def mu_of_law(fits, v, gravity):
    """mu of steady slip by the law that the points show, at velocities v (m/s); None: not known."""
    verdict = fits.verdict
    if not verdict:
        mu = fits.one("mu_ac").value
        return np.full_like(v, mu) if np.isfinite(mu) else None
    law = next((law for law in verdict.get("laws", []) if law.get("name") == verdict.get("chosen")), None)
    if law is None or verdict.get("refused"):
        return None
    p = {str(x.get("name")): number(x.get("value")) for x in law.get("parameters", [])}
    mu, speed = number(law.get("mu")), np.abs(v)
    shape = np.where(v < 0, p.get("mu backwards/forwards", 1), 1.0)
    if law["name"] == "logarithmic":
        shape = 1 + p.get("B", np.nan) * np.log1p(speed / 1e-3)
    if law["name"] == "stribeck":
        shape = 1 + (p.get("mu_s/mu_k", np.nan) - 1) * np.exp(-(speed / p.get("v_s", np.nan)) ** 2)
    return mu * shape + p.get("c", 0) * speed / gravity


def fig_friction(sources):
    known = list({id(s.analysis): s for s in sources if len(s.analysis.fits.friction)}.values())
    if not known:
        raise Missing("it needs the fits of 'shakerd mu' with slips of 6 frames or more between their kinks.")
    figure, axes = plt.subplots(figsize=(6.4, 3))
    for k, s in enumerate(known):
        v, mu, error = s.analysis.fits.friction.T
        points(axes, 1e3 * v, mu, error, colour_of(k), s.marker, k == 0, plain(s.campaign.label))
        for sign in (-1, 1):
            line = sign * np.linspace(0, np.max(np.abs(v)), 200)
            law = mu_of_law(s.analysis.fits, line, s.setting.gravity)
            if law is not None:
                axes.plot(1e3 * line, law, color=colour_of(k), lw=1)
    axes.axvline(0, color="0.5", lw=0.6)
    axes.set(xlabel="$v_R$ (mm/s)", ylabel="mu")
    axes.legend(loc="upper center", fontsize=6.5)
    return figure
