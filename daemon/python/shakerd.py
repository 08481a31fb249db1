"""Recordings, campaigns and live benches of shakerd as arrays with units and errors.

    >>> import shakerd
    >>> with shakerd.Recording("run.nxs") as run:
    ...     v = run.results["v_D"]
    ...     t, x = run.track("top", "walker")["t"], run.track("top", "walker")["x"]
    >>> v.unit, bool(v.error > 0)
    ('m/s', True)
    >>> t.unit, x.unit, x.value.shape == x.error.shape == t.value.shape
    ('s', 'm', True)

All numbers are in the SI units that the file states. An error is a standard error; a covering interval has two
of them to each side. NaN: not known. Needs h5py; Bench also needs requests, and Table.frame() needs pandas.
"""
from __future__ import annotations

import contextlib
import dataclasses
import json
import os
import pathlib
import subprocess
import time
from collections.abc import Callable, Iterator, Mapping
from typing import Any

import h5py
import numpy as np

__all__ = ["Bench", "BenchError", "Campaign", "FileError", "Quantity", "Recording", "Table"]

RECORDING_SCHEMA = 11 # newest version that this file reads; FORMAT.md lists them
CAMPAIGN_SCHEMA = 2
_UNITS = {"_mps2": "m/s^2", "_mps": "m/s", "_hz": "Hz", "_rad": "rad", "_m": "m", "_s": "s", "": "1"}


class FileError(ValueError):
    """A file that is not what was asked for, or of a version that is not known here."""


class BenchError(RuntimeError):
    """The daemon refused an order, or did not answer. The text is the daemon's own sentence."""


@dataclasses.dataclass(frozen=True)
class Quantity:
    """Values with their unit and, where the file has one, their standard error.

    >>> v = Quantity(np.array([0.0145]), np.array([7e-7]), "m/s")
    >>> _ = print(v), print(v.to("mm/s", 1e3))
    [0.0145] +- [7.e-07] m/s
    [14.5] +- [0.0007] mm/s
    >>> np.asarray(v).tolist()
    [0.0145]
    """

    value: Any  # float or array
    error: Any  # of the same shape; None: the quantity has no error
    unit: str

    def __array__(self, dtype: Any = None) -> np.ndarray:
        return np.asarray(self.value, dtype=dtype)

    def __float__(self) -> float:
        return float(self.value)

    def __len__(self) -> int:
        return len(self.value)

    def __getitem__(self, part: Any) -> Quantity:
        return Quantity(self.value[part], None if self.error is None else self.error[part], self.unit)

    def to(self, unit: str, factor: float) -> Quantity:
        """In another unit: the values are multiplied by the factor."""
        return Quantity(self.value * factor, None if self.error is None else self.error * abs(factor), unit)

    def __str__(self) -> str:
        unit = "" if self.unit == "1" else f" {self.unit}"
        return f"{self.value}{unit}" if self.error is None else f"{self.value} +- {self.error}{unit}"


class Table(Mapping[str, Any]):
    """The columns of a group: Quantity for numbers, a list for texts. A column is read when it is asked for."""

    def __init__(self, *groups: h5py.Group, rows: Any = None) -> None:
        self._groups = groups
        self._group = {name: group for group in reversed(groups) for name in group}
        self._data = {name: item for name, group in self._group.items() if isinstance(item := group.get(name), h5py.Dataset)}
        self._rows = slice(None) if rows is None else rows

    def _read(self, name: str) -> Any:
        data, link = self._data[name], self._group[name].get(name, getlink=True)
        if isinstance(link, h5py.ExternalLink) or data.external or data.is_virtual:
            raise FileError(f"{self._groups[0].file.filename}: {self._groups[0].name}/{name} is stored in another file")
        return data[()] if data.shape == () else data[...][self._rows]

    def __getitem__(self, name: str) -> Any:
        if name not in self._data:
            raise KeyError(f"{self._groups[0].name} has no column {name!r}; it has {', '.join(self)}")
        data = self._data[name]
        if data.dtype.kind == "S":
            texts = self._read(name)
            return texts.decode() if data.shape == () else [text.decode() for text in texts]
        error = self._read(f"{name}_errors") if f"{name}_errors" in self._data else None
        unit = data.attrs.get("units", "1")
        return Quantity(self._read(name), error, unit.decode() if isinstance(unit, bytes) else str(unit))

    def __iter__(self) -> Iterator[str]:
        return (name for name in self._data if not (name.endswith("_errors") and name[:-7] in self._data))

    def __len__(self) -> int:
        return sum(1 for _ in self)

    def where(self, chosen: Any) -> Table:
        """The rows that `chosen` (indices or flags) names."""
        return Table(*self._groups, rows=np.arange(len(next(iter(self._data.values()))))[self._rows][chosen])

    def frame(self) -> Any:
        """A pandas.DataFrame; its units are in attrs["units"]."""
        import pandas  # only here

        read, columns = dict(self), dict[str, Any]()
        for name, column in read.items():
            columns[name] = getattr(column, "value", column)
            if getattr(column, "error", None) is not None:
                columns[f"{name}_errors"] = column.error
        out = pandas.DataFrame(columns)
        out.attrs["units"] = {name: column.unit for name, column in read.items() if isinstance(column, Quantity)}
        return out


class _File(contextlib.AbstractContextManager):
    def __init__(self, path: str | os.PathLike[str], newest: int, needed: str, kind: str) -> None:
        self.path = pathlib.Path(path)
        if not self.path.is_file():
            raise FileError(f"{self.path}: no such file; expected {kind}")
        try:
            self._file = h5py.File(self.path, "r", libver="latest", swmr=True)
        except OSError as error:
            raise FileError(f"{self.path}: cannot be read as HDF5 ({error}); expected {kind}") from None
        if needed not in self._file.get("entry", {}):
            self.close()
            raise FileError(f"{self.path}: has no group entry/{needed}; expected {kind}")
        self.entry: h5py.Group = self._file["entry"]
        self.schema = int(self.entry["process"].attrs.get("schema", 1))
        if self.schema > newest:
            self.close()
            raise FileError(f"{self.path}: is of version {self.schema}, this shakerd.py reads up to {newest}; "
                            "take the shakerd.py of the program that wrote it")

    @property
    def settings(self) -> str:
        """The settings or the plan, TOML."""
        return bytes(self.entry["process/config_text"][()]).decode()

    def table(self, path: str) -> Table:
        """Any group below /entry, for example "periods" or "identification/response"."""
        if path not in self.entry:
            raise FileError(f"{self.path}: has no group entry/{path}")
        return Table(self.entry[path])

    def law(self) -> dict[str, Any]:
        """What `shakerd law` (of the PATH, or the variable SHAKERD) finds: chosen, sentence, laws; friction: mu at v_R, by no law."""
        program = os.environ.get("SHAKERD", "shakerd")
        try:
            done = subprocess.run([program, "law", "--json", self.path], capture_output=True, text=True, check=True)
        except (OSError, subprocess.CalledProcessError) as e:
            raise FileError(f"{self.path}: {program} law: {str(getattr(e, 'stderr', '') or e).strip()}") from None
        verdict: dict[str, Any] = json.loads(done.stdout)
        quantity = lambda of, error, unit: Quantity(*(np.nan if x is None else x for x in (of, error)), unit)
        for law in verdict["laws"]:
            law["mu"] = quantity(law["mu"], law.pop("mu_error"), "1")
            law["parameters"] = {p["name"]: quantity(p["value"], p["error"], p["unit"]) for p in law["parameters"]}
        v_R, mu, error = (np.array([f[key] for f in verdict["friction"]]) for key in ("v_R_mps", "mu", "mu_error"))
        friction = {"v_R": Quantity(v_R, None, "m/s"), "mu": Quantity(mu, error, "1")}
        return verdict | {"laws": {law["name"]: law for law in verdict["laws"]}, "friction": friction}

    def close(self) -> None:
        self._file.close()

    def __exit__(self, *_: Any) -> None:
        self.close()


class Recording(_File):
    """One run. Opens also a file that still grows (run.nxs.part)."""

    def __init__(self, path: str | os.PathLike[str]) -> None:
        super().__init__(path, RECORDING_SCHEMA, "raw", "a recording of shakerd")

    def refresh(self) -> None:
        """Makes rows visible that were added to a growing file."""
        self.entry.visititems(lambda _, item: item.id.refresh() if isinstance(item, h5py.Dataset) else None)

    @property
    def results(self) -> Table:
        """The last finished measurement: v_D, D, gamma, phi, rho, frequency, v_rms, efficiency."""
        return self.table("results")

    @property
    def measured(self) -> Table:
        """A row for each finished measurement; asked_* are the set-points. Details in table("measured/...")."""
        return Table(self.entry["measured"], self.entry["measured/results"])

    @property
    def cycle(self) -> Table:
        """The averaged period: x, v, v_base against phase (0 to 1)."""
        return self.table("cycle")

    @property
    def tracks(self) -> list[str]:
        """CAMERA/TARGET of each track."""
        return [f"{camera}/{target}" for camera, targets in self.entry["tracks"].items() for target in targets]

    def track(self, camera: str, target: str) -> Table:
        """t (master time) and x of a target. state: FORMAT.md; 2 and 6 are lost, 1, 4 and 5 in doubt."""
        return self.table(f"tracks/{camera}/{target}")

    @property
    def notes(self) -> list[str]:
        """What restricts the results, one sentence each."""
        return list(self.table("results/notes")["text"])

    @property
    def acceleration(self) -> Quantity:
        """Samples of the accelerometer, m/s^2: a row each, columns x, y, z of the sensor; fewer where it has fewer axes."""
        group, get = self.entry["raw/accelerometer"], self.entry["raw/accelerometer"].attrs.get
        gain = [[get(f"cross_mps2_per_count_{i}{k}", (i == k) * get(f"mps2_per_count_{i}")) for k in "xyz"] for i in "xyz"]
        offset = [get(f"offset_counts_{axis}") for axis in "xyz"]
        return Quantity((group["counts"][...] + offset) @ np.transpose(gain)[:, :int(get("axes", 3))], None, "m/s^2")


class Campaign(_File):
    """A campaign's folder: its points, and the recordings that they come from.

    >>> with Campaign("points") as campaign:
    ...     points = campaign.measured
    ...     print(points["v_D"].unit, len(points["phi"]), [file.name for file in campaign.recordings])
    m/s 4 ['r001.nxs']
    """

    def __init__(self, folder: str | os.PathLike[str]) -> None:
        folder = pathlib.Path(folder)
        self.folder = folder.parent if folder.is_file() else folder
        super().__init__(self.folder / "campaign.nxs", CAMPAIGN_SCHEMA, "points", "the folder of a campaign")

    @property
    def points(self) -> Table:
        """A row for each point of the plan, also those that failed: outcome, reason."""
        return self.table("points")

    @property
    def measured(self) -> Table:
        """The points that were measured."""
        return self.points.where([outcome == "measured" for outcome in self.points["outcome"]])

    @property
    def recordings(self) -> list[pathlib.Path]:
        """The recordings of the points, without repeats."""
        return [self.folder / f"{name}.nxs" for name in dict.fromkeys(self.table("passes")["recording"]) if name]


class Bench:
    """A bench on call: `shakerd serve`.

    >>> bench = Bench("http://127.0.0.1:8080")  # doctest: +SKIP
    >>> bench.drive(gamma=9.81, phi=1.745)  # doctest: +SKIP
    >>> print(bench.measure(periods=20)["v_D"])  # doctest: +SKIP
    0.006599 +- 6e-07 m/s
    """

    def __init__(self, url: str = "http://127.0.0.1:8080", token: str | None = None, name: str = "python") -> None:
        """token: as in the daemon's token_file; name: how the log and other clients see this one."""
        import requests  # only here

        self.url = url.rstrip("/")
        self._session = requests.Session()
        self._session.headers["X-Shaker-Client"] = name
        if token is not None:
            self._session.headers["X-Shaker-Token"] = token
        self._failures = requests.RequestException

    def _ask(self, method: str, path: str, body: Mapping[str, Any] | None = None) -> Any:
        try:
            answer = self._session.request(method, f"{self.url}/api/{path}", json=body, timeout=5)
        except self._failures as error:
            raise BenchError(f"{self.url}: no answer ({error})") from None
        try:
            content = answer.json()
        except ValueError:
            raise BenchError(f"{self.url}/api/{path}: status {answer.status_code}, not JSON") from None
        if not answer.ok:
            raise BenchError(content.get("error", f"status {answer.status_code}"))
        return content

    def ready(self, timeout: float = 30) -> Bench:
        """Returns this bench when its daemon has started. BenchError with the reason when the time is over."""
        end = time.monotonic() + timeout
        while time.monotonic() < end:
            with contextlib.suppress(BenchError):
                _ = self.state
                return self
            time.sleep(0.1)
        _ = self.state
        return self

    @staticmethod
    def _until(found: Callable[[], Any], timeout: float, late: str) -> Any:
        end = time.monotonic() + timeout
        while not (answer := found()):
            if time.monotonic() > end:
                raise TimeoutError(f"{late} after {timeout:g} s")
            time.sleep(0.05)
        return answer

    def close(self) -> None:
        self._session.close()

    def order(self, action: str, **body: Any) -> None:
        """Any order of `orders`, for example order("loop", closed=False)."""
        self._ask("POST", action, body)

    @property
    def orders(self) -> list[dict[str, Any]]:
        """The daemon's orders with the keys, ranges and help of their fields."""
        return list(self._ask("GET", "orders"))

    @property
    def state(self) -> dict[str, Any]:
        """All that the daemon publishes, with the keys of GET /api/state."""
        return dict(self._ask("GET", "state"))

    def drive(self, *, gamma: float | None = None, phi: float | None = None, rho: float | None = None,
              frequency: float | None = None) -> None:
        """Changes the set-point: m/s^2, rad, 1, Hz. What is not given stays."""
        self.order("drive", gamma_mps2=gamma, phi_rad=phi, rho=rho, frequency_hz=frequency)

    def start(self, periods: int | None = None, settle: int | None = None) -> None:
        """Drives and measures until stop(). What is not given is as last."""
        self.order("start", periods=periods, settle_periods=settle)

    def stop(self) -> None:
        self.order("stop")

    def abort(self) -> None:
        """Latched until clear(). Needs neither control nor token."""
        self.order("abort")

    def clear(self, timeout: float = 5) -> None:
        """Ends a trip; waits until the drive is silent, before which that is refused."""
        self._until(lambda: self.state["session"]["may_clear"], timeout, "not silent")
        self.order("clear")
        self._until(lambda: self.state["session"]["state"] != "tripped", timeout, "still tripped")

    def record(self, name: str, frames: str = "first-second") -> None:
        """The next run is recorded under this name; frames: off, first-second, region, full."""
        self.order("record", on=True, name=name, frames=frames)

    def wait(self, *states: str, timeout: float = 60) -> str:
        """Returns the bench's state when it is one of these. BenchError after a trip, TimeoutError in the end."""
        def found() -> str:
            session = self.state["session"]
            if session["state"] == "tripped" and "tripped" not in states:
                raise BenchError(str((session["trip"] or {}).get("text", "tripped")))
            return str(session["state"]) if session["state"] in states else ""
        return str(self._until(found, timeout, f"not {' or '.join(states)}"))

    @property
    def result(self) -> dict[str, Quantity]:
        """The newest measurement: v_D, D, gamma, phi, ... BenchError before the first."""
        flat, out = self._ask("GET", "result"), {}
        for key, value in flat.items():  # NAME_UNIT, and its error NAME_se_UNIT
            name, suffix = next((key.removesuffix(s), s) for s in _UNITS if key.endswith(s))
            if isinstance(value, (int, float)) and not isinstance(value, bool) and not name.endswith("_se"):
                out[name] = Quantity(value, flat.get(f"{name}_se{suffix}"), _UNITS[suffix])
        return out

    def measure(self, periods: int | None = None, timeout: float = 120) -> dict[str, Quantity]:
        """A measurement at the present set-point, begun after this call; starts the drive if it is off."""
        before = self.state["result"].get("number")
        if self.wait("idle", "armed", "settling", "running", timeout=timeout) in ("idle", "armed"):
            self.start(periods)
            before = None
        def found() -> bool:
            self.wait("armed", "identifying", "checking", "ramping", "settling", "running", timeout=timeout)
            newest = self.state["result"]
            return newest.get("number") not in (None, before) and bool(newest.get("current", False))
        self._until(found, timeout, "no measurement")
        return self.result

    def campaign(self, plan: str = "", timeout: float = 86400, **scan: Any) -> str:
        """A plan, or scan="phi" or "gamma" with start, stop (SI), steps, periods. Returns the name of its folder."""
        ends = {"from": scan.pop("start"), "to": scan.pop("stop")} if scan else {"plan": plan}
        self.order("campaign", **ends, **scan)
        def ended() -> str:
            now = self.state["campaign"]
            if now["paused"]:
                raise BenchError(f"the campaign is paused: {now['newest']}")
            return "" if now["active"] else str(now["folder"])
        return str(self._until(ended, timeout, "the campaign goes on"))
