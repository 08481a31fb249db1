#!/usr/bin/python3
"""Jobs, rows and the table of an archive. The Snakefile beside it calls this file; without Snakemake:

    archive_rows.py rows jobs/JOB.json rows/JOB.jsonl    one shakerd process for each item of the job
    archive_rows.py table TABLE.csv jobs/INDEX.txt       the rows of all jobs as one table
"""
import csv
import functools
import hashlib
import json
import os
import pathlib
import shutil
import signal
import subprocess
import sys
from dataclasses import dataclass

STOPPED = {signal.SIGHUP, signal.SIGINT, signal.SIGTERM}  # of the job, not of an item: the row is left to the next try


@dataclass(frozen=True)
class Kind:
    """What is done with each item of an archive; items are the files that match the pattern."""
    pattern: str
    per_job: int  # items of a job, so that it lasts minutes
    commands: object  # (file, settings) -> arguments of shakerd, one list for each process


def replayed(file, settings):
    return [["replay", file, *(word for pair in settings["set"] for word in ("--set", pair)), "--json"]]


def simulated(file, settings):
    folder = pathlib.Path("campaigns", settings["name"]).with_suffix("")
    if (folder / "journal.jsonl").exists():
        if (folder / "plan.toml").read_bytes() != pathlib.Path(file).read_bytes():
            raise ValueError(f"{folder} has a campaign of another plan; rename the plan, or work in a new folder")
        measured = ["campaign", str(folder), "--continue"]
    else:
        folder.parent.mkdir(parents=True, exist_ok=True)
        scene = ["--scene", settings["scene"]] if settings["scene"] else []
        measured = ["campaign", file, "--rig", "sim:", *scene, "-o", str(folder)]
    return [measured, ["mu", str(folder), "--json"]]


KINDS = {
    "replay": Kind("*.nxs", 200, replayed),
    "reduce": Kind("*.nxs", 200, replayed),
    "footage": Kind("session.toml", 5, lambda file, settings: [["reduce", file, "--json"]]),
    "mu": Kind("campaign.nxs", 50, lambda file, settings: [["mu", file, "--json"]]),
    "campaign": Kind("campaign.nxs", 10, lambda file, settings: [["campaign", os.path.dirname(file), "--reduce"]]),
    "simulate": Kind("*.toml", 5, simulated),
}
KEYS = {"do", "archive", "set", "scene", "per_job", "program"}


def checked(config):
    """The values of --config, complete; a wrong one ends the program with a sentence."""
    if unknown := sorted(set(config) - KEYS):
        sys.exit(f"--config {unknown[0]}: unknown key; expected one of {', '.join(sorted(KEYS))}")
    if (do := config.get("do")) not in KINDS:
        sys.exit(f"--config do={do}: expected one of {', '.join(KINDS)}")
    if not os.path.isdir(archive := str(config.get("archive", ""))):
        sys.exit(f"--config archive={archive}: no such folder; expected the folder of the files")
    pairs = config.get("set", [])
    pairs = pairs.split() if isinstance(pairs, str) else list(pairs)
    if bool(pairs) != (do == "reduce"):
        sys.exit(f"--config set='{' '.join(pairs)}': do=reduce needs KEY=VALUE ..., as in shakerd replay --set; no other takes it")
    scene = config.get("scene")
    if scene is not None and (do != "simulate" or not os.path.isfile(scene)):
        sys.exit(f"--config scene={scene}: expected a file that exists, with do=simulate")
    per_job = config.get("per_job", KINDS[do].per_job)
    if not isinstance(per_job, int) or per_job < 1:
        sys.exit(f"--config per_job={per_job}: expected a number of files, 1 or more")
    program = shutil.which(config.get("program", "shakerd"))
    if program is None:
        sys.exit(f"--config program={config.get('program', 'shakerd')}: no such program; expected the path of shakerd")
    return {"do": do, "archive": os.path.abspath(archive), "set": pairs, "scene": scene and os.path.abspath(scene),
            "program": os.path.abspath(program)}, per_job


def stamp(path):
    """Size and time of change; of the link itself where it leads nowhere."""
    state = os.stat(path) if os.path.exists(path) else os.lstat(path)
    return [state.st_size, state.st_mtime_ns]


def items(settings):
    """[name, size, time of change] of each item, in the order of the table."""
    root = pathlib.Path(settings["archive"])
    own = pathlib.Path("campaigns").absolute() if settings["do"] == "simulate" else None
    found = (path for path in root.rglob(KINDS[settings["do"]].pattern)
             if own not in path.parents and (path.name != "campaign.nxs" or KINDS[settings["do"]].pattern == path.name))
    return sorted([path.relative_to(root).as_posix(), *stamp(path)] for path in found)


def keep(path, text):
    """Writes a file at once, or not at all; one that exists has this text already."""
    if not os.path.exists(path):
        os.makedirs(os.path.dirname(path), exist_ok=True)
        with open(f"{path}.{os.getpid()}", "w", encoding="ascii") as file:
            file.write(text)
        os.replace(file.name, path)


@functools.cache
def jobs(text):
    """Divides the archive into jobs. A job's name is the hash of all that its rows depend on: settings, program, names,
    sizes and times of its files. So jobs that are done stay done while an archive grows. Returns names and index."""
    settings, per_job = checked(json.loads(text))
    version = subprocess.run([settings["program"], "--version"], capture_output=True, text=True, check=True).stdout
    settings["made with"] = [version, stamp(settings["program"]), settings["scene"] and stamp(settings["scene"])]
    found, names = items(settings), []
    if not found:
        sys.exit(f"{settings['archive']}: no file {KINDS[settings['do']].pattern} in it or below")
    for first in range(0, len(found), per_job):
        job = json.dumps({"settings": settings, "items": found[first:first + per_job]}, indent=0)
        names.append(hashlib.sha256(job.encode()).hexdigest()[:20])
        keep(f"jobs/{names[-1]}.json", job)
    index = "".join(f"rows/{name}.jsonl\n" for name in names)
    path = f"jobs/{hashlib.sha256(index.encode()).hexdigest()[:20]}.txt"
    keep(path, index)
    return names, path


def text_of(value):
    """A cell: numbers as shakerd printed them."""
    if isinstance(value, list):
        return ";".join(map(text_of, value))
    if isinstance(value, bool):
        return str(value).lower()
    return "" if value is None else value


def cells(output):
    """The columns that an output has: its numbers and lists of numbers, and its fits by name."""
    try:
        values = json.loads(output, parse_float=str, parse_int=str)
    except ValueError:
        return {"result": (output.strip().split("\n") or [""])[-1]}
    row = {key: text_of(value) for key, value in values.items()
           if not isinstance(value, dict) and not (isinstance(value, list) and any(isinstance(one, dict) for one in value))}
    for fit in values.get("fits", []):
        if fit["gamma_mps2"] is None and not fit["series"]:
            name = fit["name"] + ("" if fit["unit"] == "1" else f" [{fit['unit']}]")
            row |= {name: text_of(fit["value"]), f"{name} se": text_of(fit["error"])}
            row |= {f"{fit['name']} {key}": text_of(fit[key]) for key in ("chi2", "freedom", "note")}
    return row


def row_of(name, settings):
    """The row of one item: its values, and for one that failed status and reason."""
    file = os.path.join(settings["archive"], name)
    status, reason, output = 0, "", ""
    try:
        if not os.path.isfile(file):  # a pipe would be waited for
            raise ValueError("is a link that leads nowhere" if os.path.islink(file) else "is not a file")
        for arguments in KINDS[settings["do"]].commands(file, settings | {"name": name}):
            done = subprocess.run([settings["program"], *arguments], capture_output=True, stdin=subprocess.DEVNULL,
                                  text=True, errors="replace", check=False)
            status, output = done.returncode, done.stdout
            if status < 0:
                status = 128 - status  # as a shell counts signals
            if status - 128 in STOPPED:
                sys.exit(f"{name}: stopped by signal {status - 128}")
            if status != 0:
                reason = (done.stderr.strip().split("\n") or [""])[-1] or f"ended with status {status}"
                break
    except (OSError, ValueError) as error:
        status, reason = 2, str(error)
    return {"file": name, "status": str(status), "reason": reason} | (cells(output) if output else {})


def known_rows(journal, names):
    """Rows of an earlier try that was interrupted; a line that is not whole does not count."""
    rows = {}
    if os.path.exists(journal):
        with open(journal, encoding="ascii", errors="replace") as file:
            for line in file:
                try:
                    row = json.loads(line)
                    rows[row["file"]] = row
                except (ValueError, TypeError, KeyError):
                    continue
    return {name: rows[name] for name in names if name in rows}


def make_rows(job, out):
    """All rows of a job. Each is kept in a journal as soon as it is known, until the table is made: after a crash Snakemake
    repeats a job whose end it had not noted, and removes its rows first."""
    with open(job, encoding="ascii") as file:
        content = json.load(file)
    names = [name for name, *_ in content["items"]]
    journal = pathlib.Path(job).with_suffix(".journal")
    rows = known_rows(journal, names)
    with open(journal, "a", encoding="ascii") as kept:
        kept.write("\n")  # ends a line that a crash cut
        for name in names:
            if name not in rows:
                rows[name] = row_of(name, content["settings"])
                kept.write(json.dumps(rows[name]) + "\n")
                kept.flush()
    with open(f"{out}.{os.getpid()}", "w", encoding="ascii") as file:
        file.writelines(json.dumps(rows[name]) + "\n" for name in names)
        file.flush()
        os.fsync(file.fileno())
    os.replace(file.name, out)


def row_files(index):
    return pathlib.Path(index).read_text(encoding="ascii").splitlines()


def rows_of(index):
    for path in row_files(index):
        with open(path, encoding="ascii") as rows:
            yield from map(json.loads, rows)


def shown(name):
    """A name that no spreadsheet takes for a formula; as a path it is the same file."""
    return f"./{name}" if name.startswith(("=", "+", "-", "@", "\t", "\r")) else name


def make_table(out, index):
    """One table in the order of the names. A column stands where the first row has it, so jobs leave no trace."""
    columns = dict.fromkeys(column for row in rows_of(index) for column in row)
    with open(f"{out}.{os.getpid()}", "w", encoding="utf-8", errors="surrogateescape", newline="") as file:
        table = csv.DictWriter(file, list(columns), restval="", lineterminator="\n")
        table.writeheader()
        table.writerows(row | {"file": shown(row["file"])} for row in rows_of(index))
    os.replace(file.name, out)
    for path in row_files(index):  # Snakemake knows that these jobs have ended
        pathlib.Path(index).with_name(pathlib.Path(path).stem).with_suffix(".journal").unlink(missing_ok=True)


if __name__ == "__main__":
    if len(sys.argv) != 4 or sys.argv[1] not in ("rows", "table"):
        sys.exit(__doc__)
    (make_rows if sys.argv[1] == "rows" else make_table)(*sys.argv[2:])
