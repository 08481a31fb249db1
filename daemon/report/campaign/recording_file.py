"""A single recording as numbers and arrays: daemon/recording/FORMAT.md."""
import dataclasses

import h5py
import numpy as np

from campaign_file import InputError, table, texts

KINDS = {"run": "", "trip": "The last 2 s before a limit stopped a run that was not recorded.", "session": "Footage of others."}
QUANTITIES = ("v_D", "D", "gamma", "phi", "rho", "frequency", "efficiency")
COLUMNS = {"results": [*QUANTITIES, *(f"{name}_errors" for name in QUANTITIES)],
           "cycle": ["phase", "x", "x_errors", "v", "v_errors", "v_base"], "stick": ["from", "to", "errors"],
           "measured": ["measurement", "asked_gamma", "asked_phi"]}


@dataclasses.dataclass
class Measurement:
    name: str
    asked: dict     # set-point; empty: not known
    results: dict   # column -> value; NaN: not known
    cycle: dict     # column -> array; empty arrays: not reduced
    stick: dict
    truth: float    # true v_D of a simulated bench, m/s; NaN: not known


@dataclasses.dataclass
class Recording:
    label: str
    path: str
    title: str
    words: str            # program, date, kind
    measurements: list
    settings: list        # (name, text)
    events: list          # (time, state, text)
    notes: list           # sentences: trips, reasons why there are no results


def kind_of(path):
    """Kind of the file; empty: a folder, or not to be read."""
    try:
        with h5py.File(path, "r") as f:
            return texts(f["entry"], path, "process/kind")[0]
    except (OSError, KeyError, ValueError, TypeError, RuntimeError):
        return ""


def read_recording(path, label):
    try:
        with h5py.File(path, "r") as f:
            return recording_of(f["entry"], path, label)
    except (OSError, KeyError, IndexError, ValueError, TypeError, RuntimeError) as error:
        raise InputError(f"{path}: damaged or not a recording ({error}); expected a recording of 'shakerd run'") from None


def columns(entry, path, name, *more):
    """The needed columns of a table as numbers; all have the same length."""
    found = table(entry, name, path, "a recording of 'shakerd run'")
    found = {key: np.asarray(found[key], float) for key in [*COLUMNS[name.split("/")[-1]], *more]}
    if len({np.shape(column) for column in found.values()}) > 1:
        raise ValueError(f"columns of /entry/{name} differ in length")
    return found


def recording_of(entry, path, label):
    title, program, version, start, kind, config, rig, reason = texts(
        entry, path, "title", "process/program", "process/version", "start_time", "process/kind", "process/config_text",
        "process/rig_text", "process/not_reduced")
    read = lambda name: table(entry, name, path, "a recording of 'shakerd run'")
    events, notes = read("events"), list(read("trips")["words"])
    truth = float(read("truth").get("v_D", np.nan)) if "truth" in entry else np.nan
    last = [Measurement(label, {}, *(columns(entry, path, part) for part in ("results", "cycle", "stick")), truth)]
    found = measurements(entry, path, label) if "measured" in entry else []
    if len(found) < 2:  # the only one has its truth; one that a trip interrupted is not among the finished ones
        last[0].asked = found[0].asked if found else {}
        found = last if np.isfinite(last[0].results["v_D"]) else []
    if found:
        notes += list(read("results/notes" if found is last else "measured/notes")["text"])
    else:
        notes.append(f"No results: {reason or 'no measurement was finished'}.")
    return Recording(label, path, title, f"{program} {version}, {start}. {KINDS.get(kind, '')}", found,
                     [("settings", config), ("rig", rig)], list(zip(events["t"], events["state"], events["text"])), notes)


def measurements(entry, path, label):
    """Finished measurements; NaN and empty columns for one that could not be reduced."""
    measured = columns(entry, path, "measured")
    parts = [columns(entry, path, f"measured/{part}", "measurement") for part in ("results", "cycle", "stick")]
    found = []
    for k, n in enumerate(measured["measurement"]):
        results, cycle, stick = ({key: column[part["measurement"] == n] for key, column in part.items()} for part in parts)
        found.append(Measurement(f"{label} #{n:.0f}", {key: column[k] for key, column in measured.items()},
                                 {key: column[0] if len(column) else np.nan for key, column in results.items()}, cycle, stick,
                                 np.nan))
    return found
