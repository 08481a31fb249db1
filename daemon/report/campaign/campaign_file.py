"""A campaign as arrays: campaign.nxs with the plan, the journal and, for a simulated bench, the scene beside it."""
import dataclasses
import json
import os
import pathlib
import tomllib

import h5py
import numpy as np

from walker_law import G, Drives

MOST_EVENTS = 2000      # lines of the journal in the page
MOST_TEXT = 200_000     # characters of a text from a file
MOST_VALUES = 20_000_000  # of a column
MOST_PICTURE = 5_000_000  # bytes


class InputError(Exception):
    """The input is not a campaign; the message names the file, the value and what is expected."""


@dataclasses.dataclass
class Campaign:
    label: str            # name in legends, unique in one report
    path: pathlib.Path    # campaign.nxs
    title: str
    plan: str             # text of the plan
    program: str          # program and version that wrote the file
    points: dict          # column -> array, a row for each point; see daemon/campaign/POINTS.md
    harmonics: dict       # q: (Q,); the other columns (points, Q)
    cycle: dict           # phase: (P,); the other columns (points, P)
    stick: dict           # column -> array, a row for each interval
    passes: dict
    journal: list         # entries of journal.jsonl, without "point begun" and complete passes
    scene: dict           # scene of a simulated bench; empty: real bench, or no recording
    picture: pathlib.Path | None  # picture of the bench in the folder
    notes: list           # sentences about files that could not be read
    gravity: float = G    # m/s^2, at the place

    @property
    def measured(self):
        p = self.points
        return (p["outcome"] == "measured") & np.isfinite(p["v_D"]) & np.isfinite(p["gamma"]) & np.isfinite(p["phi"])

    @property
    def phi_errors(self):
        """Error of phi, from the phases of harmonics 1 and 2 where these are known."""
        e, q = self.harmonics.get("phase_errors"), list(self.harmonics["q"])
        if e is None or 1 not in q or 2 not in q:
            return self.points["phi_errors"]
        return np.fmin(self.points["phi_errors"], np.hypot(2 * e[:, q.index(1)], e[:, q.index(2)]))

    def truth(self, name):
        """mu_k, mu_s (1) or tilt (rad) of a simulated scene; NaN: not known."""
        if name == "tilt":
            degrees = number(self.scene.get("tilt_deg"))
            return np.radians(degrees)
        return number(self.scene.get("walker", {}).get(name))

    def drives(self, rows):
        """Motion of the base as measured, at the given points."""
        amplitude, phase = (np.nan_to_num(self.harmonics[k][rows]) for k in ("amplitude", "phase"))
        return Drives(self.points["frequency"][rows], self.harmonics["q"], amplitude, phase, self.gravity)

    def asked_drives(self, rows):
        amplitude, phase = (np.nan_to_num(self.harmonics[k][rows]) for k in ("asked_amplitude", "asked_phase"))
        return Drives(self.points["asked_frequency"][rows], self.harmonics["q"], amplitude, phase, self.gravity)


def number(value):
    return float(value) if isinstance(value, (int, float)) else np.nan


def words(data):
    """Text of a dataset: a str, or an array of str. Bytes that are not UTF-8 are replaced."""
    value = data[()]
    decode = lambda b: (b if isinstance(b, bytes) else str(b).encode()).decode("utf-8", "replace")[:MOST_TEXT]
    return decode(value) if np.ndim(value) == 0 else np.array([decode(b) for b in value], dtype=object)


def check_own(data, link, what):
    """The values are in this file, and there are not too many of them."""
    if isinstance(link, h5py.ExternalLink) or data.external or data.is_virtual:
        raise InputError(f"{what} is stored in another file; expected all columns in campaign.nxs")
    if data.size > MOST_VALUES:
        raise InputError(f"{what} has {data.size} values; expected {MOST_VALUES} at most")


def table(entry, name, path, expected="campaign.nxs of 'shakerd campaign'"):
    if name not in entry or not isinstance(entry[name], h5py.Group):
        raise InputError(f"{path}: no group /entry/{name}; expected {expected}")
    columns = {}
    for key in entry[name]:
        data = entry[name][key]
        if isinstance(data, h5py.Dataset):
            check_own(data, entry[name].get(key, getlink=True), f"{path}: /entry/{name}/{key}")
            columns[key] = words(data) if data.dtype.kind in "SO" else np.asarray(data[()], float)
    return columns


def texts(entry, path, *names):
    """Single texts; empty where the file does not have one."""
    for name in names:
        if isinstance(entry.get(name), h5py.Dataset):
            check_own(entry[name], entry.get(name, getlink=True), f"{path}: /entry/{name}")
    return [str(words(entry[name])) if name in entry else "" for name in names]


POINT_NUMBERS = ("point", "repeat", "partner", "asked_frequency", "asked_gamma", "asked_rho", "asked_phi", "v_D",
                 "v_D_errors", "frequency", "gamma", "gamma_errors", "rho", "phi", "phi_errors", "v_rms", "efficiency",
                 "efficiency_errors", "true_v_D", "chi2", "periods")
NEEDED = {"points": POINT_NUMBERS + ("series", "outcome", "reason"),
          "harmonics": ("q", "amplitude", "phase", "asked_amplitude", "asked_phase"),
          "cycle": ("phase", "x", "v", "v_errors", "v_base"), "stick": ("point", "from", "to", "errors"),
          "passes": ("point", "pass", "how", "reason")}
TEXTS = ("series", "outcome", "reason", "how", "recording", "time", "doubt")


def columns_needed(name):
    return [column for column in NEEDED[name] if column not in TEXTS]


def read_tables(entry, path):
    tables = {name: table(entry, name, path) for name in NEEDED}
    for name, columns in NEEDED.items():
        for column in columns:
            if column not in tables[name]:
                raise InputError(f"{path}: no column /entry/{name}/{column}; expected campaign.nxs of 'shakerd campaign'")
    rows = len(tables["points"]["point"])
    for name, columns in tables.items():
        axis = {"harmonics": "q", "cycle": "phase"}.get(name)
        first = rows if axis else len(columns["point"])
        for column, data in columns.items():
            if column in TEXTS and data.dtype.kind != "O" or column in columns_needed(name) and data.dtype.kind == "O":
                raise InputError(f"{path}: /entry/{name}/{column} has the type {data.dtype}; expected"
                                 f" {'text' if column in TEXTS else 'numbers'}")
            shape = (len(columns[axis]),) if column == axis else (first,)
            if axis and column not in (axis, "point"):
                shape += (len(columns[axis]),)
            if data.shape != shape:
                raise InputError(f"{path}: /entry/{name}/{column} has the shape {data.shape}; expected {shape}")
    return tables


def find_file(given):
    path = pathlib.Path(given)
    if path.is_dir():
        if not (path / "campaign.nxs").is_file():
            raise InputError(f"{path}: no campaign.nxs in this folder; expected the folder of a campaign"
                             " ('shakerd campaign FOLDER --reduce' makes the file again)")
        return path / "campaign.nxs"
    if not path.is_file():
        raise InputError(f"{path}: no such file or folder; expected the folder of a campaign or its campaign.nxs")
    return path


def read_campaign(given, label=None):
    path = find_file(given)
    try:
        with h5py.File(path, "r") as f:
            if "entry" not in f:
                raise InputError(f"{path}: no group /entry; expected campaign.nxs of 'shakerd campaign'")
            entry = f["entry"]
            kind = words(entry["process/kind"]) if "process/kind" in entry else "unknown"
            if kind != "campaign":
                raise InputError(f"{path}: kind of file is '{kind[:60]}'; expected 'campaign', or recordings alone")
            tables = read_tables(entry, path)
            gravity = float(entry["process"].attrs.get("gravity_mps2", G))
            title, plan, program, version = texts(entry, path, "title", "process/config_text", "process/program",
                                                  "process/version")
    except OSError as error:
        raise InputError(f"{path}: cannot be read as HDF5 ({error}); expected campaign.nxs") from None
    except (KeyError, ValueError, TypeError, RuntimeError) as error:
        raise InputError(f"{path}: damaged or not a campaign ({error}); expected campaign.nxs") from None
    folder, notes = path.resolve().parent, []
    journal = read_journal(folder / "journal.jsonl", notes)
    doubts = [(int(n), d) for n, d in zip(tables["points"]["point"], tables["points"].get("doubt", [])) if d]
    if doubts:
        notes.append(f"The measurements of {len(doubts)} points are in doubt, so is every fit. Point {doubts[0][0]}: {doubts[0][1]}")
    scene = read_scene(folder, tables["points"], notes)
    return Campaign(label or folder.name, path, title, plan, f"{program} {version}".strip(), journal=journal, scene=scene,
                    picture=find_picture(folder), notes=notes, gravity=gravity, **tables)


def read_journal(path, notes):
    """Entries other than the plain course of a campaign: its changes, failures, early ends, lost passes."""
    found = []
    try:
        with open(path, encoding="utf-8", errors="replace") as lines:
            for line in lines:
                try:
                    entry = json.loads(line[:10_000])
                    what = entry["what"]
                except (ValueError, KeyError, TypeError):
                    notes.append("The journal has a line that is not an entry.")
                    continue
                plain = (what == "point begun" or what == "pass ended" and entry.get("how") == "complete"
                         or what == "point ended" and entry.get("outcome") == "measured")
                if not plain and len(found) < MOST_EVENTS:
                    found.append(entry)
    except OSError as error:
        notes.append(f"The journal could not be read: {error.strerror}.")
    return found


def read_scene(folder, points, notes):
    """Scene of a simulated bench, from a recording of the folder; only where the points have true values."""
    if not np.isfinite(points["true_v_D"]).any():
        return {}
    for name in dict.fromkeys(points.get("recording", [])):
        path = folder / (os.path.basename(name) + ".nxs")
        if not name or not path.is_file():
            continue
        try:
            with h5py.File(path, "r") as f:
                scene = tomllib.loads(words(f["entry/process/rig_text"]))
                if f"{scene.get('run', {}).get('rig', 'sim:')}".startswith("sim") and "walker" in scene:
                    return scene
        except (OSError, KeyError, RuntimeError, tomllib.TOMLDecodeError) as error:
            notes.append(f"The scene in {path.name} could not be read: {error}.")
    notes.append("True v_D is known, the scene (true mu, tilt) is not: no readable recording beside campaign.nxs.")
    return {}


def find_picture(folder):
    for name in ("bench.png", "bench.jpg", "bench.jpeg"):
        path = folder / name
        if path.is_file() and not path.is_symlink() and path.stat().st_size <= MOST_PICTURE:
            return path
    return None


def unmeasured(campaign):
    """(point, series, set-point, outcome, reason) of each point without a result that was begun or left out."""
    p, rows = campaign.points, []
    for k in np.flatnonzero(~campaign.measured & (campaign.points["outcome"] != "not begun")):
        if p["outcome"][k] != "measured":
            reason = p["reason"][k]
        else:
            reason = "v_D, gamma or phi is not a number"
        setting = f"{p['asked_gamma'][k] / G:.3g} g, {np.degrees(p['asked_phi'][k]):.4g} deg"
        rows.append((f"{p['point'][k]:.0f}", p["series"][k], setting, p["outcome"][k], reason))
    return rows
