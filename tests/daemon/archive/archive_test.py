#!/usr/bin/python3
"""Tests of daemon/archive: one table, however the work is divided, stopped and resumed.    SHAKER_BUILD=build/dev PROGRAM"""
import contextlib
import csv
import json
import os
import pathlib
import shutil
import signal
import subprocess
import sys
import tempfile
import unittest

ROOT = pathlib.Path(__file__).resolve().parents[3]
ARCHIVE = ROOT / "daemon/archive"
sys.dont_write_bytecode = True
sys.path.insert(0, str(ARCHIVE))

import archive_rows

PROGRAM = pathlib.Path(os.environ.get("SHAKER_BUILD", ROOT / "build/dev")).resolve() / "shakerd"
SCENE = "[top]\npositions = 1\n[side]\npositions = 1\n"
PLAN = '[[series]]\ngamma = "1g"\nphi = {from = "0deg", to = "180deg", steps = 3}\nperiods = 10\n'
# Writes its calls down. FATAL: the first that kills all processes of its group, as a power cut would; STOPPED: the first that
# is stopped.
COUNTED = """#!/bin/sh
[ "$1" != --version ] || exec %s --version
echo "$2" >>calls
[ "$(wc -l <calls)" -lt "${FATAL:-1000}" ] || kill -KILL 0
[ "$(wc -l <calls)" -lt "${STOPPED:-1000}" ] || kill -TERM $$
exec %s "$@"
"""
GOOD = ["a.nxs", "b 2.nxs", "night/{c}.nxs", "night/d.nxs", "night/e.nxs"]


class ArchiveTest(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.folder = pathlib.Path(tempfile.mkdtemp())
        (cls.folder / "scene.toml").write_text(SCENE)
        (cls.folder / "counted").write_text(COUNTED % (PROGRAM, PROGRAM))
        (cls.folder / "counted").chmod(0o755)
        archive = cls.folder / "archive"
        (archive / "night").mkdir(parents=True)
        for name, phi in zip(GOOD[:2], ("0deg", "40deg")):
            subprocess.run([PROGRAM, "run", "--scene", cls.folder / "scene.toml", "--no-identify", "--gamma", "0.7g", "--phi", phi,
                            "--periods", "4", "--frames", "off", "-o", archive / name], check=True, capture_output=True)
        for name in GOOD[2:]:
            shutil.copy(archive / GOOD[0], archive / name)
        (archive / "night/cut.nxs").write_bytes((archive / GOOD[0]).read_bytes()[:100000])
        cls.names = sorted([*GOOD, "night/cut.nxs"])

    @classmethod
    def tearDownClass(cls):
        os.chdir("/")
        shutil.rmtree(cls.folder)

    def setUp(self):
        os.chdir(tempfile.mkdtemp(dir=self.folder))

    def config(self, **values):
        return {"archive": str(self.folder / "archive"), "do": "replay", "program": str(self.folder / "counted"), **values}

    def sequential(self, **values):
        """The table by one process, in one job."""
        archive_rows.jobs.cache_clear()
        names, index = archive_rows.jobs(json.dumps(self.config(per_job=1000, **values)))
        for name in names:
            os.makedirs("rows", exist_ok=True)
            archive_rows.make_rows(f"jobs/{name}.json", f"rows/{name}.jsonl")
        archive_rows.make_table("sequential.csv", index)
        return pathlib.Path("sequential.csv").read_bytes()

    def snakemake(self, fatal=1000, status=0, **values):
        pairs = [f"{key}={value}" for key, value in self.config(**values).items()]
        done = subprocess.run(["snakemake", "-s", ARCHIVE / "Snakefile", "--profile", ARCHIVE / "profiles/local", "--config", *pairs],
                              env={**os.environ, "FATAL": str(fatal)}, start_new_session=True, text=True, check=False,
                              stdout=subprocess.PIPE, stderr=subprocess.STDOUT, timeout=300)
        self.assertEqual(done.returncode, status, done.stdout)
        return done.stdout

    def one_job(self):
        """The name of the only job, and the index."""
        archive_rows.jobs.cache_clear()
        (job,), index = archive_rows.jobs(json.dumps(self.config()))
        os.mkdir("rows")
        return job, index

    def rows_command(self, job):
        return [ARCHIVE / "archive_rows.py", "rows", f"jobs/{job}.json", f"rows/{job}.jsonl"]

    def rows(self, table):
        return list(csv.DictReader(table.decode().split("\n")))

    def calls(self):
        """The names of the files whose rows were computed, in that order."""
        files = pathlib.Path("calls").read_text().split("\n")[:-1]
        return [pathlib.Path(file).relative_to(self.folder / "archive").as_posix() for file in files]

    def kept(self):
        """The names of the rows that are whole on the disk."""
        names = set()
        for path in [*pathlib.Path("jobs").glob("*.journal"), *pathlib.Path("rows").glob("*.jsonl")]:
            for line in path.read_text().split("\n"):
                with contextlib.suppress(ValueError):
                    names.add(json.loads(line)["file"])
        return names

    def test_jobs_leave_no_trace_in_the_table(self):
        self.snakemake(per_job=2)
        parallel = pathlib.Path("replay.csv").read_bytes()
        self.assertEqual(len(list(pathlib.Path("rows").iterdir())), 3)
        self.assertEqual(parallel, self.sequential())
        self.assertEqual([row["file"] for row in self.rows(parallel)], self.names)
        for row in self.rows(parallel):
            done = subprocess.run([PROGRAM, "replay", self.folder / "archive" / row["file"], "--json"], capture_output=True,
                                  text=True, check=False)
            self.assertEqual(int(row["status"]), done.returncode)
            if done.returncode == 0:
                for key in ("v_D_mps", "v_D_se_mps", "gamma_mps2", "phi_rad", "D_m", "efficiency"):
                    self.assertIn(f'"{key}": {row[key]},', done.stdout)
        late = self.folder / "archive/z.nxs"
        shutil.copy(self.folder / "archive/a.nxs", late)
        pathlib.Path("calls").unlink()
        try:
            self.snakemake(per_job=2)
            self.assertEqual(self.calls(), ["z.nxs"])  # earlier jobs stay done while the archive grows
            self.assertEqual(pathlib.Path("replay.csv").read_bytes(), self.sequential())
        finally:
            late.unlink()

    def test_a_failed_recording_is_a_row_with_its_reason(self):
        rows = {row["file"]: row for row in self.rows(self.sequential())}
        cut = rows["night/cut.nxs"]
        self.assertEqual((cut["status"], cut["v_D_mps"]), ("2", ""))
        self.assertRegex(cut["reason"], r"^shakerd: .*/night/cut\.nxs: cannot be opened: truncated file")
        self.assertEqual({(rows[name]["status"], rows[name]["reason"]) for name in GOOD}, {("0", "")})

    def test_each_bad_item_is_a_row(self):
        """As many rows as items, and no name that a spreadsheet would compute."""
        bad = self.folder / "bad"
        bad.mkdir()
        (bad / "gone.nxs").symlink_to("nowhere.nxs")
        os.mkfifo(bad / "pipe.nxs")
        (bad / "folder.nxs").mkdir()
        (bad / "empty.nxs").touch()
        (bad / "text.nxs").write_text("no recording")
        formulas = ["=1+1.nxs", "+a.nxs", "-b.nxs", "@c.nxs"]
        odd = ["two\nlines.nxs", "quote'\".nxs", "$(id).nxs", os.fsdecode(b"\xff\xfe.nxs")]
        for name in [*formulas, *odd]:
            (bad / name).write_text("no recording")
        shutil.copy(self.folder / "archive" / GOOD[0], bad / "good.nxs")
        with open(os.devnull, "w", encoding="ascii") as nothing, contextlib.redirect_stdout(nothing):
            table = self.sequential(archive=str(bad))
        rows = {row["file"]: row for row in csv.DictReader(table.decode(errors="surrogateescape").splitlines(True))}
        self.assertEqual(len(rows), 6 + len(formulas) + len(odd))
        self.assertEqual({name for name, row in rows.items() if row["status"] == "0"}, {"good.nxs"})
        self.assertEqual({f"./{name}" for name in formulas} - set(rows), set())
        self.assertEqual(rows["gone.nxs"]["reason"], "is a link that leads nowhere")
        for name in "pipe.nxs", "folder.nxs":
            self.assertEqual(rows[name]["reason"], "is not a file")
        self.assertTrue(all(row["reason"] for name, row in rows.items() if name != "good.nxs"))

    def test_goes_on_after_a_kill_of_all_processes(self):
        self.snakemake(fatal=5, status=-signal.SIGKILL, per_job=3)  # the job of the fifth call has made a row
        self.assertFalse(os.path.exists("replay.csv"))
        before, kept = self.calls(), self.kept()
        self.assertEqual(len(before), len(set(before)))
        for job in (self.names[:3], self.names[3:]):
            self.assertLessEqual({*[name for name in job if name in before][:-1]}, kept)  # kept before the job's next call
        self.snakemake(per_job=3)
        self.assertCountEqual(self.calls()[len(before):], set(self.names) - kept)  # each row that was not kept, and no other
        self.assertEqual(pathlib.Path("replay.csv").read_bytes(), self.sequential())

    def test_a_job_that_is_repeated_keeps_its_rows(self):
        job, index = self.one_job()
        for _ in range(2):
            subprocess.run(self.rows_command(job), check=True)
            os.unlink(f"rows/{job}.jsonl")  # as Snakemake does when a crash left it unaware of the job's end
        subprocess.run(self.rows_command(job), check=True)
        self.assertEqual(self.calls(), self.names)
        archive_rows.make_table("replay.csv", index)
        self.assertEqual(set(os.listdir("jobs")), {f"{job}.json", os.path.basename(index)})
        self.assertEqual(pathlib.Path("replay.csv").read_bytes(), self.sequential())

    def test_a_row_that_a_crash_cut_is_made_again(self):
        whole = self.sequential()
        rows, = pathlib.Path("rows").iterdir()
        lines = rows.read_text().split("\n")
        rows.unlink()
        pathlib.Path("calls").unlink()
        (pathlib.Path("jobs") / f"{rows.stem}.journal").write_text("\n".join(lines[:2]) + "\n" + lines[2][:50])
        self.assertEqual(self.sequential(), whole)
        self.assertEqual(len(self.calls()), len(self.names) - 2)

    def test_a_stopped_job_leaves_the_row_to_the_next_try(self):
        job, index = self.one_job()
        command = self.rows_command(job)
        stopped = subprocess.run(command, env={**os.environ, "STOPPED": "2"}, text=True, check=False, capture_output=True)
        self.assertEqual((stopped.returncode, stopped.stderr.strip()), (1, f"{self.names[1]}: stopped by signal 15"))
        self.assertEqual(os.listdir("rows"), [])
        subprocess.run(command, check=True)
        archive_rows.make_table("replay.csv", index)
        self.assertEqual(len(self.calls()), len(self.names) + 1)
        self.assertEqual(pathlib.Path("replay.csv").read_bytes(), self.sequential())

    def test_plans_are_simulated_fitted_and_reduced(self):
        os.mkdir("plans")
        pathlib.Path("plans/two.toml").write_text(PLAN)
        pathlib.Path("plans/wrong.toml").write_text(PLAN.replace("1g", "1000000g"))
        values = {"archive": "plans", "do": "simulate", "scene": str(self.folder / "scene.toml")}
        good, wrong = self.rows(self.sequential(**values))
        self.assertEqual((good["file"], good["status"]), ("two.toml", "0"))
        self.assertAlmostEqual(float(good["mu_ac"]), 0.113, delta=5 * float(good["mu_ac se"]))
        self.assertEqual(wrong["status"], "2")
        self.assertIn("gamma", wrong["reason"])
        fitted, = self.rows(self.sequential(archive="campaigns", do="mu"))
        self.assertEqual((fitted["file"], fitted["mu_ac"]), ("two/campaign.nxs", good["mu_ac"]))
        reduced, = self.rows(self.sequential(archive="campaigns", do="campaign"))
        self.assertEqual((reduced["status"], reduced["result"]), ("0", "reduce: identical (4 points, to the bit)"))
        pathlib.Path("plans/two.toml").write_text(PLAN.replace("180deg", "170deg"))
        self.assertIn("campaigns/two has a campaign of another plan", self.rows(self.sequential(**values))[0]["reason"])

    def test_reduces_with_other_settings(self):
        rows = {row["file"]: row for row in self.rows(self.sequential(do="reduce", set="top.mm_per_px=0.2 side.mm_per_px=0.2"))}
        recorded = {row["file"]: row for row in self.rows(self.sequential())}
        self.assertEqual(rows["a.nxs"]["status"], "0")
        self.assertLess(float(rows["a.nxs"]["v_D_mps"]), 0.9 * float(recorded["a.nxs"]["v_D_mps"]))

    def test_wrong_values_are_refused_with_a_sentence(self):
        for values, words in (({"do": "erase"}, "--config do=erase: expected one of replay, reduce,"),
                              ({"archive": "none"}, "--config archive=none: no such folder"),
                              ({"do": "reduce"}, "do=reduce needs KEY=VALUE"),
                              ({"per_job": 0}, "--config per_job=0: expected a number of files, 1 or more"),
                              ({"per_jobs": 2}, "--config per_jobs: unknown key; expected one of"),
                              ({"program": "none"}, "--config program=none: no such program"),
                              ({"scene": "none"}, "--config scene=none: expected a file"),
                              ({"do": "mu"}, "no file campaign.nxs in it or below")):
            with self.assertRaises(SystemExit) as refused:
                self.sequential(**values) if "per_job" not in values else archive_rows.checked(self.config(**values))
            self.assertIn(words, refused.exception.code)


if __name__ == "__main__":
    unittest.main(argv=sys.argv)
