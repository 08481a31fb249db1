"""Settled motion of a walker on a base that vibrates with any harmonics, under the laws of friction of `shakerd predict`,
and the closed form of the paper.

  a_B(t) = sum over q of A_q sin(2 pi q u + alpha_q),  u = t / T

Closed form (no stick), any rho:  kappa = pi mu g / (2 rho gamma),  Theta = 2 asin(kappa),  valid for kappa <= 1
  v_D = gamma (1 - rho) / (2 w) cos(phi - Theta)
"""
import dataclasses
import json
import os
import shutil
import subprocess
import tempfile

import numpy as np

G = 9.8  # m/s^2, the unit g; gravity at a place is that of the campaign


@dataclasses.dataclass
class Drives:
    """Motion of the base in B drives: amplitude (m/s^2) and sine phase (rad) of the harmonics q, each (B, Q)."""
    frequency: np.ndarray  # Hz, (B,)
    q: np.ndarray          # (Q,)
    amplitude: np.ndarray
    phase: np.ndarray
    g: float = G           # m/s^2, gravity at the place

    def __len__(self):
        return len(self.frequency)

    def velocity(self, row, u):
        """Of the base in one drive at the phases u, m/s."""
        w = 2 * np.pi * self.frequency[row] * self.q
        return -np.cos(2 * np.pi * np.outer(u, self.q) + self.phase[row]) @ (self.amplitude[row] / w)


def biharmonic(gamma, phi, rho=0.5, frequency=20.0, g=G):
    """Drives a_B = gamma [rho sin(w t) + (1 - rho) sin(2 w t + phi)]; arguments are broadcast together."""
    gamma, phi, rho, frequency = (np.ravel(a).astype(float) for a in np.broadcast_arrays(gamma, phi, rho, frequency))
    amplitude = np.stack([gamma * rho, gamma * (1 - rho)], -1)
    return Drives(frequency, np.array([1, 2]), amplitude, np.stack([0 * phi, phi], -1), g)


@dataclasses.dataclass
class Motion:
    """Settled motion of B drives."""
    v_D: np.ndarray  # m/s
    events: list     # for each drive a list of (u, s): at phase u begins slip s = +1, -1 or stick s = 0; the first at u = 0
    v: np.ndarray    # m/s, (B, phases): velocity at t/T = i / phases; (B, 0) where no phases were asked for


@dataclasses.dataclass
class Law:
    """A law of friction with its parameters, and how curves of it are named."""
    mu: float
    error: float = 0.0       # standard error of mu
    words: str = "exact law"
    mu_name: str = "mu_ac"   # empty: the paper's
    friction: dict = dataclasses.field(default_factory=dict)  # further keys of `shakerd predict`
    static: float = 1.0      # mu_s / mu
    vertical: complex = 0j   # a_z over a_B: share in phase, less i times the share a quarter of a period later
    refused: bool = False    # by the data

    def settle(self, drives, more_mu=0.0, **options):
        mu = self.mu + more_mu
        return settle(drives, mu, self.static * mu, vertical=self.vertical, **self.friction, **options)


def settle(drives, mu, mu_s=0.0, tilt=0.0, vertical=0j, **options):
    """Settled motion of each drive, from rest on the base. mu, mu_s and tilt (rad) are numbers or (B,) arrays; options: further
    keys of a case. One call of `shakerd` for all; the variable SHAKERD names another program than that of the PATH."""
    mu, mu_s, tilt = (np.broadcast_to(np.asarray(a, float), len(drives)) for a in (mu, mu_s, tilt))
    harmonics = lambda k, share: [{"q": int(q), "a": a * abs(share), "phase": p + float(np.angle(share))}
                                  for q, a, p in zip(drives.q, drives.amplitude[k], drives.phase[k]) if a * share != 0]
    cases = [{"name": str(k), "params": {
        "f_hz": drives.frequency[k], "g": drives.g, "mu_k": mu[k], "mu_s": max(mu[k], mu_s[k]), "tilt_deg": np.degrees(tilt[k]),
        "base_accel": harmonics(k, 1), "vertical_accel": harmonics(k, vertical), **options}} for k in range(len(drives))]
    with tempfile.NamedTemporaryFile("w", suffix=".json") as file:
        json.dump({"cases": cases}, file)
        file.flush()
        program = os.environ.get("SHAKERD") or shutil.which("shakerd") or "shakerd"
        done = subprocess.run([program, "predict", "--json", file.name], check=True, stdout=subprocess.PIPE)
    answers = json.loads(done.stdout) if cases else {}
    found = [answers[case["name"]] for case in cases]
    events = [[(0.0, f["state_at_t0"]), *((u, after) for u, _, after in f["events"])] for f in found]
    return Motion(np.array([f["v_D"] for f in found]), events, np.array([f.get("v", []) for f in found]))


def stick_intervals(motion, row):
    """Intervals (from, to) of rest on the base in periods; to is above 1 when it continues in the next period."""
    starts = motion.events[row]
    found = [(u, end) for (u, s), (end, _) in zip(starts, [*starts[1:], (1.0, None)]) if s == 0]
    if len(found) > 1 and found[0][0] == 0 and found[-1][1] == 1:
        found[-1] = (found[-1][0], 1 + found.pop(0)[1])
    return [(begin, end) for begin, end in found if end - begin > 1e-9]


def closed_theta(gamma, mu, rho=0.5, g=G):
    with np.errstate(divide="ignore", invalid="ignore"):
        kappa = np.pi * mu * g / (2 * rho * np.asarray(gamma, float))
        return 2 * np.arcsin(np.where(kappa <= 1, kappa, np.nan))


def closed_drift(gamma, phi, mu, rho=0.5, frequency=20.0, g=G):
    return gamma * (1 - rho) / (4 * np.pi * frequency) * np.cos(phi - closed_theta(gamma, mu, rho, g))


def null_theta(gamma, law, rho=0.5, frequency=20.0, g=G):
    """Null phase of a law less pi/2, rad; NaN without one."""
    gamma = np.ravel(gamma).astype(float)
    low, high = np.full(len(gamma), np.pi / 2 - 0.1), np.full(len(gamma), np.pi / 2 + 2.2)
    drift = lambda phi: law.settle(biharmonic(gamma, phi, rho, frequency, g)).v_D
    valid = (drift(low) > 1e-9) & (drift(high) < -1e-9)
    rows = np.arange(len(gamma))
    for _ in range(2):  # to 0.006 rad, where the curve is a line
        phases = np.linspace(low, high, 21)
        v = drift(phases).reshape(phases.shape)
        k = np.clip((v > 0).sum(0) - 1, 0, 19)
        low, high, above, below = phases[k, rows], phases[k + 1, rows], v[k, rows], v[k + 1, rows]
    with np.errstate(divide="ignore", invalid="ignore"):
        return np.where(valid, (low * below - high * above) / (below - above) - np.pi / 2, np.nan)
