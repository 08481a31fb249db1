"""Settings of a campaign: points that differ in gamma and phi only."""
import dataclasses

import numpy as np

from walker_law import Drives, biharmonic

CIRCLE_PHASES = 6     # least number of phases around the circle
LARGEST_GAP = 1.65    # rad between neighbours of these phases


@dataclasses.dataclass
class Setting:
    """Points that differ in gamma and phi only."""
    frequency: float
    rho: float
    overtones: tuple   # ((q, share of gamma, sine phase), ...) at 0 <= phi < pi; a mirror partner has even ones reversed
    rows: np.ndarray   # measured points
    gravity: float     # m/s^2, at the place

    @property
    def like_the_paper(self):
        return self.rho == 0.5 and not self.overtones

    @property
    def words(self):
        extra = "".join(f", {100 * share:.2g} % of {q}f" for q, share, _ in self.overtones)
        return f"{self.frequency:.4g} Hz, rho {self.rho:.3g}{extra}"

    def drives(self, gamma, phi):
        """Drives as asked for; gamma and phi are broadcast together."""
        d = biharmonic(gamma, phi, self.rho, self.frequency, self.gravity)
        gamma = d.amplitude.sum(1)
        return Drives(d.frequency, np.array([1, 2, *(q for q, _, _ in self.overtones)]),
                      np.column_stack([d.amplitude, *(gamma * share for _, share, _ in self.overtones)]),
                      np.column_stack([d.phase, *(0 * gamma + phase for _, _, phase in self.overtones)]), self.gravity)


def settings_of(campaign):
    """Settings of the measured points. The first is the one that `shakerd mu` fits, where there is one: rho = 1/2, no overtones,
    the frequency with the most points. Then those with the most points."""
    p, h, found = campaign.points, campaign.harmonics, {}
    for k in np.flatnonzero(campaign.measured):
        share = np.nan_to_num(h["asked_amplitude"][k] / p["asked_gamma"][k])
        mirror = np.mod(p["asked_phi"][k] + 1e-6, 2 * np.pi) >= np.pi
        overtones = tuple((int(q), round(s, 5), round(np.mod(phase + np.pi * (mirror and q % 2 == 0) + 1e-6, 2 * np.pi), 4))
                          for q, s, phase in zip(h["q"], share, np.nan_to_num(h["asked_phase"][k])) if q > 2 and s > 1e-6)
        found.setdefault((round(p["asked_frequency"][k], 4), round(p["asked_rho"][k], 4), overtones), []).append(k)
    settings = [Setting(*key, np.array(rows), campaign.gravity) for key, rows in found.items()]
    return sorted(settings, key=lambda s: (not s.like_the_paper, -len(s.rows), s.frequency))


def circles(campaign, setting):
    """{gamma: rows}: points of one series whose phases go around the circle; of several series the one with most points."""
    p, found = campaign.points, {}
    gammas = np.round(p["asked_gamma"], 4)
    for gamma in np.unique(gammas[setting.rows]):
        for series in dict.fromkeys(p["series"][setting.rows]):
            rows = setting.rows[(gammas[setting.rows] == gamma) & (p["series"][setting.rows] == series)]
            phases = np.unique(np.round(np.mod(p["asked_phi"][rows] + 1e-6, 2 * np.pi), 4))
            around = len(phases) >= CIRCLE_PHASES and np.max(np.diff([*phases, phases[0] + 2 * np.pi])) <= LARGEST_GAP
            if around and len(rows) > len(found.get(gamma, ())):
                found[float(gamma)] = rows
    return found


def near_phase(phi, wanted, tolerance=0.01):
    return np.abs(np.angle(np.exp(1j * (np.asarray(phi) - wanted)))) < tolerance
