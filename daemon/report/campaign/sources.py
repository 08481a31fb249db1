"""Sources of the figures: each setting (frequency, rho, overtones) of each campaign, with its look and its theory."""
import dataclasses

import numpy as np

from drawing import LINES, MARKERS, REFUSED, plain, with_error
from settings import circles
from walker_law import G, null_theta

MOST_SOURCES = 6     # in one set of figures
MOST_CURVES = 3      # sources of which theory is drawn


@dataclasses.dataclass
class Source:
    analysis: object
    setting: object
    label: str
    marker: str
    line: object
    curves: bool        # theory is drawn for this source
    circles: dict       # gamma: points around the circle, see circles()
    solved: dict = dataclasses.field(default_factory=dict)  # curves of law_drift()

    @property
    def law(self):
        return self.analysis.law

    @property
    def campaign(self):
        return self.analysis.campaign

    def column(self, name, rows=None):
        return self.campaign.points[name][self.setting.rows if rows is None else rows]

    def fits(self, name):
        """Fits at one gamma, for the setting that has them."""
        return self.analysis.fits.named(name) if self.setting is self.analysis.settings[0] else []

    def law_drift(self, gamma, phi):
        """v_D of the law on the drive as asked for and a level base: with mu, and with mu less and plus two errors."""
        gamma, phi = (np.ascontiguousarray(a) for a in np.broadcast_arrays(gamma, phi))
        name = gamma.tobytes() + phi.tobytes()
        if name not in self.solved:  # Figs. 2(b) and 4 have the same curves
            drives = self.setting.drives(gamma, phi)
            middle, high = (self.law.settle(drives, more).v_D.reshape(gamma.shape) for more in (0, 2 * self.law.error))
            self.solved[name] = middle, 2 * middle - high, high
        return self.solved[name]

    def law_null(self, gamma):
        """Theta of the law, as law_drift(). The band: as if Theta depended on gamma / mu only, which is exact for Coulomb's."""
        theta = null_theta(gamma, self.law, self.setting.rho, self.setting.frequency, self.setting.gravity)
        change = 2 * self.law.error / self.law.mu * gamma * np.gradient(theta, gamma)
        return theta, theta + change, theta - change

    @property
    def law_words(self):
        law = self.law
        mu = f"{law.mu_name} = {with_error(law.mu, law.error)}" if law.mu_name else "mu = 0.113 (the paper's)"
        return f"{plain(law.words)}, {mu}"


def sources_of(analyses):
    """(sources, sentence about those that were left out)."""
    found, seen = [], []
    for a in analyses:
        for k, setting in enumerate(a.settings):
            label = a.campaign.label + (f": {setting.words}" if len(a.settings) > 1 else "")
            found.append((a, setting, plain(label, 48)))
    sources = []
    for n, (a, setting, label) in enumerate(found[:MOST_SOURCES]):
        look = (setting.frequency, setting.rho, setting.overtones, a.law.words)
        new = not any(look == other and abs(mu / a.law.mu - 1) < 0.01 for other, mu in seen)
        curves = new and len(seen) < MOST_CURVES
        if curves:
            seen.append((look, a.law.mu))
        line = REFUSED if a.law.refused else LINES[n]
        sources.append(Source(a, setting, label, MARKERS[n], line, curves, circles(a.campaign, setting)))
    left = len(found) - len(sources)
    return sources, f"{left} more settings are not drawn; the figures have {MOST_SOURCES} at most." if left > 0 else ""


def folded(source, rows):
    """phi in 0 .. pi and v_D of the points; a mirror partner at phi + pi is shown as -v_D at phi (filled: False)."""
    phi = np.mod(source.column("asked_phi", rows) + 1e-6, 2 * np.pi) - 1e-6
    mirror = phi > np.pi - 1e-5
    return np.where(mirror, phi - np.pi, phi), np.where(mirror, -1, 1) * source.column("v_D", rows), ~mirror


def phases_with_gammas(sources, least=3, most=8):
    """Phases in 0 .. pi that were measured at several gammas, those with most gammas first, then in rising order."""
    count = {}
    for s in sources:
        phi, _, _ = folded(s, s.setting.rows)
        gamma = np.round(s.column("asked_gamma"), 4)
        for value in np.unique(np.round(phi, 3)):
            n = len(np.unique(gamma[np.abs(phi - value) < 0.002]))
            near = next((k for k in count if abs(k - value) < 0.003), value)
            count[near] = max(n, count.get(near, 0))
    least = max([least, *(0.5 * n for n in count.values())])
    best = sorted((k for k in count if count[k] >= least), key=lambda k: (-count[k], k))[:most]
    return sorted(best)


def gamma_range(sources, count=60):
    g = np.concatenate([s.column("gamma") for s in sources])
    return np.linspace(max(0.1 * G, g.min() * 0.8), g.max() * 1.03, count)
