"""Fits of campaigns, as `shakerd mu --json` prints them: quantities with errors, budgets, and the law at each point."""
import dataclasses
import json
import pathlib

import numpy as np

from campaign_file import InputError, number
from walker_law import Law

MU_PAPER, MU_PAPER_ERROR = 0.113, 0.003  # 0.113(6): 95 % interval
KEYS = {"c": "viscous", "s_0": "presliding", "v_s": "stribeck", "B": "log_share", "mu backwards/forwards": "backward"}
LAWS = {"logarithmic": "logarithmic", "dahl": "dahl", "dahl_viscous": "dahl", "stribeck": "stribeck"}


@dataclasses.dataclass
class Fit:
    name: str
    value: float    # NaN: not fitted; the note has the reason
    error: float    # standard error from the errors of the points
    truth: float    # the same fit to the true v_D of a simulated bench; NaN: not known
    unit: str
    chi2: float     # over its degrees of freedom
    points: float
    note: str
    gamma: float    # m/s^2; NaN: not at one gamma
    phi: float      # rad; NaN: not at one phase
    series: str

    @property
    def theta(self):
        """Of a null phase."""
        return self.value - np.pi / 2


def fit_of(given):
    get, text = lambda key: number(given.get(key)), lambda key: str(given.get(key) or "")
    chi2 = get("chi2") / max(number(given.get("freedom", 1)), 1)
    return Fit(text("name"), get("value"), get("error"), get("truth"), text("unit"), chi2, get("points"), text("note"),
               get("gamma_mps2"), get("phi_rad"), text("series"))


@dataclasses.dataclass
class Fits:
    """Fits of one campaign; empty without any."""
    all: list
    budgets: dict       # name: lines {source, share, input}, the largest share first
    rows: np.ndarray    # points of the campaign at which the law is known
    law: np.ndarray     # v_D of the law at their measured drives, with tilt and the walker's push, m/s
    z: np.ndarray       # (measured - law) / error
    friction: np.ndarray  # rows of v_R (m/s), mu, its error
    verdict: dict       # which law describes the points: as of `shakerd law --json`; empty where Coulomb's is not refused

    def named(self, name):
        return [f for f in self.all if f.name == name and np.isfinite(f.value)]

    def one(self, name):
        return next(iter(self.named(name)), fit_of({"name": name}))

    def total_error(self, name):
        """Standard error with the whole budget; without a budget that of the points."""
        fit, shares = self.one(name), [line["share"] for line in self.budgets.get(name, [])]
        return abs(fit.value) * float(np.linalg.norm(shares)) if shares else fit.error

    def law_of_curves(self):
        """The law of the curves: that which describes the points; where none does, Coulomb's, refused."""
        mu = self.one("mu_ac").value
        known = np.isfinite(mu)
        coulomb = Law(mu, self.total_error("mu_ac")) if known else Law(MU_PAPER, MU_PAPER_ERROR, mu_name="")
        if not self.verdict:
            return coulomb
        row = next((r for r in self.verdict.get("laws", []) if r.get("name") == self.verdict.get("chosen")), {})
        p = {str(x.get("name")): number(x.get("value")) for x in row.get("parameters", [])}
        mu = number(row.get("mu"))
        if self.verdict.get("refused") or not np.isfinite([mu, *p.values()]).all():
            return dataclasses.replace(coulomb, error=0.0, words="Coulomb's law, refused by the data", refused=True)
        friction = {KEYS[name]: value for name, value in p.items() if name in KEYS}
        return Law(mu, np.nan_to_num(number(row.get("mu_error"))), str(row.get("words", "")), "mu",
                   {"law": LAWS.get(str(row.get("name")), "coulomb"), **friction}, p.get("mu_s/mu_k", 1.0),
                   complex(p.get("a_z/a_B in phase", 0), -p.get("a_z/a_B a quarter late", 0)))


def fits_for(campaign, given):
    """given: the object of the campaign in --fits."""
    row = {int(n): k for k, n in enumerate(campaign.points["point"]) if np.isfinite(n)}
    known = [(row[p["point"]], number(p.get("law_v_D_mps")), number(p.get("z"))) for p in given.get("points", [])
             if p["point"] in row]
    rows, law, z = np.array([k for k in known if np.isfinite(k).all()] or np.empty((0, 3))).T
    budgets = {name: sorted((line for line in lines if np.isfinite(number(line["share"]))), key=lambda line: -abs(line["share"]))
               for name, lines in given.get("budgets", {}).items()}
    return Fits([fit_of(f) for f in given.get("fits", [])], budgets, rows.astype(int), law, z,
                np.array([[number(f.get(k)) for k in ("v_R_mps", "mu", "mu_error")] for f in given.get("friction", [])]
                         or np.empty((0, 3))), given.get("verdict") or {})


def read_fits(path, count):
    """An object for each of `count` campaigns; empty objects without a file."""
    if path is None:
        return [{}] * count
    try:
        given = json.loads(pathlib.Path(path).read_text(encoding="utf-8"))
    except OSError as error:
        raise InputError(f"{path}: {error.strerror}; expected a JSON file of fits") from None
    except ValueError as error:
        raise InputError(f"{path}: not JSON ({error}); expected a JSON file of fits") from None
    given = given if isinstance(given, list) else [given]
    if len(given) != count:
        raise InputError(f"{path}: fits of {len(given)} campaigns; expected a list with those of each of the {count} campaigns")
    for one in given:
        check(one, path)
    return given


def check(one, path):
    if not isinstance(one, dict):
        raise InputError(f"{path}: {str(one)[:60]} is not an object; expected the output of 'shakerd mu --json'")
    objects = lambda lines: isinstance(lines, list) and all(isinstance(line, dict) for line in lines)
    verdict = one.get("verdict") or {}
    if not objects(one.get("friction", [])):
        raise InputError(f'{path}: "friction" is not a list of objects; expected {{"friction": [{{"v_R_mps", "mu", "mu_error"}}]}}')
    if not (isinstance(verdict, dict) and objects(verdict.get("laws", []))
            and all(objects(law.get("parameters", [])) for law in verdict.get("laws", []))):
        raise InputError(f'{path}: "verdict" is not an object; expected that of "shakerd law --json", or null')
    if not objects(one.get("fits", [])):
        raise InputError(f'{path}: "fits" is not a list of objects; expected {{"fits": [{{"name", "value", "error", ...}}]}}')
    points = one.get("points", [])
    if not objects(points) or not all(isinstance(p.get("point"), int) for p in points):
        raise InputError(f'{path}: "points" is not a list of objects; expected {{"points": [{{"point", "law_v_D_mps", "z"}}]}}')
    budgets = one.get("budgets", {})
    lists = list(budgets.values()) if isinstance(budgets, dict) else [None]
    if not all(objects(b) and all({"source", "share"} <= set(line) for line in b) for b in lists):
        raise InputError(f'{path}: "budgets" is not an object of lists; expected {{"mu_ac": [{{"source": "gain", "share": 0.001}}]}}')
