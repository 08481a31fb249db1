"""Exact Coulomb law: the settled motion of a walker on a base that vibrates with any harmonics.

  slip:   dv/dt = g sin(tilt) - s mu_k n,   s = sign(v - v_B),   n = g cos(tilt)
  stick:  v = v_B while |a_B - g sin(tilt)| <= mu_s n; stick wins where both are possible

  a_B(t) = sum over q of A_q sin(2 pi q u + alpha_q),  u = t / T

Closed form (no stick), any rho:  kappa = pi mu g / (2 rho gamma),  Theta = 2 asin(kappa),  valid for kappa <= 1
  v_D = gamma (1 - rho) / (2 w) cos(phi - Theta)

Many drives are solved at once. A table of the base over one period finds the interval of the next event, a safeguarded
Newton iteration on the exact expression finds its phase. The settled state is the fixed point of the map v(0) -> v(T).
"""
import dataclasses

import numpy as np

G = 9.8  # m/s^2, as everywhere in shakerd
TABLE = 720  # phases in the table of one period
CHUNK = 256  # drives that are solved together
MOST_EVENTS, MOST_PERIODS = 80, 120
SETTLED = 1e-13  # m/s, change of v(0) from period to period


@dataclasses.dataclass
class Drives:
    """Motion of the base in B drives: amplitude (m/s^2) and sine phase (rad) of the harmonics q, each (B, Q)."""
    frequency: np.ndarray  # Hz, (B,)
    q: np.ndarray          # (Q,)
    amplitude: np.ndarray
    phase: np.ndarray

    def __len__(self):
        return len(self.frequency)

    def part(self, rows):
        return Drives(self.frequency[rows], self.q, self.amplitude[rows], self.phase[rows])

    def angles(self, u):
        return 2 * np.pi * self.q * np.asarray(u)[..., None] + self.phase

    def acceleration(self, u):
        return np.sum(self.amplitude * np.sin(self.angles(u)), -1)

    def jerk(self, u):  # per period
        return np.sum(2 * np.pi * self.q * self.amplitude * np.cos(self.angles(u)), -1)

    def velocity(self, u):
        w = 2 * np.pi * self.frequency[:, None] * self.q
        return -np.sum(self.amplitude / w * np.cos(self.angles(u)), -1)

    def displacement(self, u):
        w = 2 * np.pi * self.frequency[:, None] * self.q
        return -np.sum(self.amplitude / w**2 * np.sin(self.angles(u)), -1)

    def table(self, kind):
        """The base at TABLE + 1 phases, (B, TABLE + 1)."""
        angle = 2 * np.pi * np.outer(self.q, np.linspace(0, 1, TABLE + 1))
        w = 2 * np.pi * self.frequency[:, None] * self.q
        if kind == "acceleration":
            return (self.amplitude * np.cos(self.phase)) @ np.sin(angle) + (self.amplitude * np.sin(self.phase)) @ np.cos(angle)
        a = self.amplitude / w
        return (a * np.sin(self.phase)) @ np.sin(angle) - (a * np.cos(self.phase)) @ np.cos(angle)


def biharmonic(gamma, phi, rho=0.5, frequency=20.0):
    """Drives a_B = gamma [rho sin(w t) + (1 - rho) sin(2 w t + phi)]; arguments are broadcast together."""
    gamma, phi, rho, frequency = (np.ravel(a).astype(float) for a in np.broadcast_arrays(gamma, phi, rho, frequency))
    amplitude = np.stack([gamma * rho, gamma * (1 - rho)], -1)
    return Drives(frequency, np.array([1, 2]), amplitude, np.stack([0 * phi, phi], -1))


@dataclasses.dataclass
class Motion:
    """Settled motion of B drives."""
    v_D: np.ndarray       # m/s
    v0: np.ndarray        # m/s, velocity at phase 0
    settled: np.ndarray   # bool; False: no period-1 motion was found, v_D is of the last period
    events: list          # for each drive a list of (u, v, s): at phase u begins slip s = +1, -1 or stick s = 0


class Walker:
    """State of the walker on B drives, led through one period."""

    def __init__(self, drives, mu, mu_s, tilt):
        self.d, n = drives, G * np.cos(tilt)
        self.pull = np.broadcast_to(G * np.sin(tilt), len(drives)).astype(float)
        self.kinetic, self.static = (np.broadcast_to(m * n, len(drives)).astype(float) for m in (mu, np.maximum(mu, mu_s)))
        self.T = 1 / drives.frequency
        self.v_table = drives.table("velocity")
        self.a_table = drives.table("acceleration") - self.pull[:, None]

    def period(self, v0):
        """v(T), D, dv(T)/dv(0) and the events of a period that begins with v0."""
        count = len(self.d)
        self.u, self.v, self.x, self.slope = np.zeros(count), v0.copy(), np.zeros(count), np.ones(count)
        relative = self.v - self.v_table[:, 0]
        resting = np.abs(relative) < 1e-14
        self.s = np.where(resting, self._leave(self.a_table[:, 0]), np.sign(relative))
        events = [(np.arange(count), self.u.copy(), self.v.copy(), self.s.copy())]
        for _ in range(MOST_EVENTS):
            slips, rests = np.flatnonzero((self.u < 1) & (self.s != 0)), np.flatnonzero((self.u < 1) & (self.s == 0))
            if not len(slips) and not len(rests):
                break
            for rows, advance in ((slips, self._slip), (rests, self._rest)):
                if len(rows):
                    advance(rows)
                    going = rows[self.u[rows] < 1]
                    events.append((going, self.u[going].copy(), self.v[going].copy(), self.s[going].copy()))
        return self.v, self.x, self.slope, events

    def _leave(self, a, rows=slice(None)):
        """State at v = v_B, from the acceleration of the base less the pull of the tilt."""
        return np.where(np.abs(a) <= self.static[rows], 0.0, -np.sign(a))

    def _next(self, rows, sign_table):
        """First table index after the present phase where sign_table is True; TABLE + 1: none."""
        grid = np.arange(TABLE + 1)
        found = sign_table & (grid > (self.u[rows, None] * TABLE + 0.02))
        return np.where(found.any(1), found.argmax(1), TABLE + 1)

    def _slip(self, rows):
        d, T, u0, s = self.d.part(rows), self.T[rows], self.u[rows], self.s[rows]
        a = self.pull[rows] - s * self.kinetic[rows]
        grid = np.linspace(0, 1, TABLE + 1)
        relative = self.v[rows, None] + (a * T)[:, None] * (grid - u0[:, None]) - self.v_table[rows]
        k = self._next(rows, relative * s[:, None] < 0)
        ends = k <= TABLE
        high = np.minimum(k, TABLE) / TABLE
        low = np.where(ends, np.minimum(np.maximum(u0 + 1e-9, high - 1 / TABLE), high), high)
        f = lambda u: s * (self.v[rows] + a * T * (u - u0) - d.velocity(u))
        slope = lambda u: s * T * (a - d.acceleration(u))
        u = np.where(ends, falling_root(f, slope, low, high), 1.0)
        dt = (u - u0) * T
        self.x[rows] += (self.v[rows] + a * dt / 2) * dt
        self.v[rows] += a * dt
        self.u[rows] = u
        if not ends.any():
            return
        r, s, u = rows[ends], s[ends], u[ends]
        base = d.part(ends).acceleration(u) - self.pull[r]
        new = self._leave(base, r)
        new = np.where(new == s, 0.0, new)  # a slip that ends by touching the base: rest, and leave from there
        with np.errstate(divide="ignore", invalid="ignore"):
            factor = (base - s * self.kinetic[r]) / (base + s * self.kinetic[r])
        self.slope[r] *= np.where(new == 0, 0.0, np.where(np.isfinite(factor), factor, 0.0))
        self.s[r] = new

    def _rest(self, rows):
        d, T, u0 = self.d.part(rows), self.T[rows], self.u[rows]
        k = self._next(rows, np.abs(self.a_table[rows]) > self.static[rows, None])
        ends = k <= TABLE
        at = np.minimum(k, TABLE)
        high, sign = at / TABLE, np.sign(self.a_table[rows, at])
        low = np.where(ends, np.minimum(np.maximum(u0, high - 1 / TABLE), high), high)
        f = lambda u: self.static[rows] - sign * (d.acceleration(u) - self.pull[rows])
        slope = lambda u: -sign * d.jerk(u)
        u = np.where(ends, falling_root(f, slope, low, high), 1.0)
        self.x[rows] += d.displacement(u) - d.displacement(u0)
        self.v[rows], self.u[rows], self.slope[rows] = d.velocity(u), u, 0.0
        self.s[rows] = np.where(ends, -sign, 0.0)


def falling_root(f, slope, low, high):
    """Root in [low, high] of functions that are positive at low and negative at high: Newton, else halving."""
    low, high = low.copy(), high.copy()
    u = (low + high) / 2
    for _ in range(60):
        value = f(u)
        low, high = np.where(value > 0, u, low), np.where(value > 0, high, u)
        with np.errstate(divide="ignore", invalid="ignore"):
            new = u - value / slope(u)
        new = np.where((new >= low) & (new <= high), new, (low + high) / 2)
        step, u = np.abs(new - u), new
        if np.max(step) < 2e-15:
            break
    return u


def settle(drives, mu, mu_s=0.0, tilt=0.0):
    """Settled motion of each drive, from rest on the base. mu, mu_s and tilt (rad) are numbers or (B,) arrays."""
    mu, mu_s, tilt = (np.broadcast_to(np.asarray(a, float), len(drives)) for a in (mu, mu_s, tilt))
    parts = [_settle(drives.part(rows), mu[rows], mu_s[rows], tilt[rows])
             for rows in (np.arange(k, min(k + CHUNK, len(drives))) for k in range(0, len(drives), CHUNK))]
    joined = [np.concatenate([p[k] for p in parts]) if parts else np.empty(0) for k in range(3)]
    return Motion(*joined, [e for p in parts for e in p[3]])


def _settle(drives, mu, mu_s, tilt):
    count = len(drives)
    v0, D, settled = np.zeros(count), np.zeros(count), np.zeros(count, bool)
    events, left = [[] for _ in range(count)], np.arange(count)
    walker = Walker(drives, mu, mu_s, tilt)
    for turn in range(MOST_PERIODS):
        start = v0[left]
        v, x, slope, found = walker.period(start)
        D[left] = x
        done = np.abs(v - start) < SETTLED
        settled[left] = done
        last = done | (turn == MOST_PERIODS - 1)
        for rows, u, w, s in found:
            for k, one in zip(rows, zip(u, w, s)):
                if last[k]:
                    events[left[k]].append(one)
        newton = (slope < 0.999) & (turn >= 2) & (turn % 2 == 0)
        v0[left] = np.where(done, start, np.where(newton, start + (v - start) / np.where(newton, 1 - slope, 1), v))
        if done.all():
            break
        if done.any():
            left = left[~done]
            walker = Walker(drives.part(left), mu[left], mu_s[left], tilt[left])
    return D * drives.frequency, v0, settled, events


def velocity_over_period(drives, motion, row, mu, u, tilt=0.0):
    """v(t) of one drive at the phases u, m/s."""
    one, T = drives.part([row]), 1 / drives.frequency[row]
    v = np.empty_like(u)
    starts = sorted(motion.events[row], key=lambda e: e[0])
    for k, (u0, v0, s) in enumerate(starts):
        inside = (u >= u0) & (u < (starts[k + 1][0] if k + 1 < len(starts) else 2))
        a = G * np.sin(tilt) - s * mu * G * np.cos(tilt)
        v[inside] = v0 + a * T * (u[inside] - u0) if s else one.velocity(u[inside])
    return v


def stick_intervals(motion, row):
    """Intervals (from, to) of rest on the base in periods; to is above 1 when it continues in the next period."""
    starts = sorted(motion.events[row], key=lambda e: e[0])
    if all(s == 0 for _, _, s in starts):
        return [(0.0, 1.0)]
    found = []
    for k, (u0, _, s) in enumerate(starts):
        if s == 0:
            found.append([u0, starts[k + 1][0] if k + 1 < len(starts) else 1.0])
    if len(found) > 1 and found[0][0] == 0 and found[-1][1] == 1:
        found[-1][1] = 1 + found.pop(0)[1]
    return [tuple(f) for f in found if f[1] - f[0] > 1e-9]


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
