#!/usr/bin/python3
"""Tests of daemon/python: doc-tests on real files, examples, a bench on call.    SHAKER_BUILD=build/dev PROGRAM"""
import contextlib
import doctest
import os
import pathlib
import re
import shutil
import socket
import subprocess
import sys
import tempfile
import unittest
import unittest.mock

ROOT = pathlib.Path(__file__).resolve().parents[3]
sys.path.insert(0, str(ROOT / "daemon/python"))

import h5py
import numpy as np
import shakerd

PROGRAM = pathlib.Path(os.environ.get("SHAKER_BUILD", ROOT / "build/dev")).resolve() / "shakerd"
SCENE = "[top]\npositions = 1\n[side]\npositions = 1\n"
PLAN = '[[series]]\ngamma = "1g"\nphi = {from = "0deg", to = "180deg", steps = 3}\nperiods = 10\n'


# Order, JSON, words of shakerctl, SCPI command; None: SCPI has no such command or cannot say it.
WRONG = (
    ("drive", {"gamma_mps2": "200g"}, ["set", "--gamma", "200g"], "ACC 200 G"),
    ("drive", {"gamma_mps2": "0"}, ["set", "--gamma", "0"], "ACC 0"),
    ("drive", {"gamma_mps2": "1 Hz"}, ["set", "--gamma", "1 Hz"], "ACC 1 HZ"),
    ("drive", {"gamma_mps2": "90g"}, ["set", "--gamma", "90g"], "ACC 882"),
    ("drive", {"phi_rad": "800deg"}, ["set", "--phi", "800deg"], "BIH:PHAS 800 DEG"),
    ("drive", {"rho": "2"}, ["set", "--rho", "2"], "BIH:RHO 2"),
    ("drive", {"frequency_hz": "0.1Hz"}, ["set", "--frequency", "0.1Hz"], "FREQ 0.1"),
    ("start", {"periods": "1"}, ["start", "--periods", "1"], "AVER:PER 1"),
    ("start", {"periods": "2.5"}, ["start", "--periods", "2.5"], None),
    ("start", {"periods": 1000000}, ["start", "--periods", "1000000"], "AVER:PER 1000000;:INIT"),
    ("start", {"measurements": "-1"}, ["start", "--measurements", "-1"], "TRIG:COUN -1"),
    ("start", {"settle_periods": "20000"}, ["start", "--settle", "20000"], "AVER:SETT 20000"),
    ("start", {"gamma_mps2": "200g"}, ["start", "--gamma", "200g"], None),
    ("mu", {"mu": "4"}, ["mu", "4"], "WALK:MU 4"),
    ("mu", {"mu": 0.1, "sigma": 0.2}, ["mu", "0.1", "--error", "0.2"], "WALK:MU 0.1,0.2"),
    ("remark", {"text": ""}, ["remark", ""], "REC:NOTE ''"),
    ("remark", {"text": "a\tb"}, ["remark", "a\tb"], "REC:NOTE 'a\tb'"),
    ("record", {"name": "../x"}, ["record", "on", "--name", "../x"], "REC ON,'../x'"),
    ("record", {"frames": "all"}, ["record", "on", "--frames", "all"], "REC:RAW:CAM ALL"),
    ("record", {"frames": "full"}, ["record", "on", "--frames", "full"], "REC:RAW:CAM FULL"),
    ("limit", {"limit": "transverse", "value": "0.9"}, ["limit", "transverse", "0.9"], "LIM:TRAN:ABOR 0.9"),
    ("limit", {"limit": "edge", "value": "1mm"}, ["limit", "edge", "1mm"], "LIM:WALK:EDGE 0.001"),
    ("limit", {"limit": "speed", "value": "1"}, ["limit", "speed", "1"], None),
    ("limit", {"limit": "velocity", "value": "1g"}, ["limit", "velocity", "1g"], None),
    ("campaign", {"plan": "none"}, ["campaign", "start", "--plan", "none"], "CAMP:STAR 'none'"),
    ("campaign", {"plan": "a/b"}, ["campaign", "start", "--plan", "a/b"], "CAMP:STAR 'a/b'"),
    ("campaign", {"scan": "phi", "from": "0", "to": "900", "steps": 3},
     ["scan", "phi", "--from", "0", "--to", "900", "--steps", "3"], "CAMP:SCAN PHI,0,900,3"),
    ("campaign", {"scan": "rho"}, ["scan", "rho", "--from", "0", "--to", "1", "--steps", "3"], "CAMP:SCAN RHO,0,1,3"),
    ("campaign/resume", {}, ["campaign", "resume"], "CAMP:RES"),
    ("campaign/check", {"plan": "none"}, ["campaign", "check", "--plan", "none"], "CAMP:CHEC 'none'"),
    ("stop", {}, ["stop"], None),
    ("clear", {}, ["clear"], "OUTP:PROT:CLE"),
    ("targets", {"targets": [{"camera": "x", "target": "walker", "region_px": [1, 2, 30, 40]}]},
     ["targets", "--camera", "x", "--target", "walker", "--region", "1,2,30,40"], None),
)


class PythonTest(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.folder = pathlib.Path(tempfile.mkdtemp())
        (cls.folder / "scene.toml").write_text(SCENE)
        (cls.folder / "plan.toml").write_text(PLAN)
        subprocess.run([PROGRAM, "campaign", "plan.toml", "--scene", "scene.toml", "-o", "points"],
                       cwd=cls.folder, check=True, capture_output=True)
        shutil.copy(cls.folder / "points/r001.nxs", cls.folder / "run.nxs")
        os.chdir(cls.folder)

    @classmethod
    def tearDownClass(cls):
        os.chdir("/")
        shutil.rmtree(cls.folder)

    def example(self, name, *arguments):
        path = f"{PROGRAM.parent}:{os.environ['PATH']}"
        done = subprocess.run([sys.executable, ROOT / "daemon/python/examples" / name, *arguments], text=True, check=False,
                              capture_output=True, env={**os.environ, "PYTHONPATH": str(ROOT / "daemon/python"), "PATH": path},
                              timeout=120)
        self.assertEqual(done.returncode, 0, done.stdout + done.stderr)
        return done.stdout

    def test_the_examples_in_the_help_are_true(self):
        result = doctest.testmod(shakerd)
        self.assertEqual(result.failed, 0)
        self.assertGreaterEqual(result.attempted, 8)

    def test_numbers_are_those_of_the_file(self):
        with shakerd.Recording("run.nxs") as run, h5py.File("run.nxs") as file:
            self.assertEqual(float(run.results["v_D"]), file["entry/results/v_D"][()])
            self.assertEqual(run.results["v_D"].error, file["entry/results/v_D_errors"][()])
            measured = run.measured
            self.assertEqual(len(measured["v_D"]), len(measured["asked_phi"]))
            np.testing.assert_array_equal(measured["v_D"].value, file["entry/measured/results/v_D"][...])
            self.assertNotIn("v_D_errors", list(run.results))
            gravity = np.linalg.norm(run.acceleration.value.mean(axis=0))
            self.assertLess(abs(gravity - 9.81), 0.1)
            with self.assertRaisesRegex(KeyError, "no column 'speed'; it has .*v_D"):
                run.results["speed"]

    def test_rows_are_chosen_together(self):
        with shakerd.Campaign("points") as campaign:
            points = campaign.measured
            phi = points["asked_phi"].value
            late = points.where(phi > 1)
            np.testing.assert_array_equal(late["asked_phi"].value, phi[phi > 1])
            np.testing.assert_array_equal(late.where([0])["v_D"].value, points["v_D"].value[phi > 1][:1])
            self.assertEqual(len(late["recording"]), int((phi > 1).sum()))

    def test_a_column_that_is_stored_in_another_file_is_refused(self):
        (self.folder / "private.raw").write_bytes(bytes(800))
        with h5py.File("private.h5", "w") as other:
            other["secret"] = np.arange(100.0)
        for kind in "link", "raw", "virtual":
            shutil.copy("run.nxs", f"{kind}.nxs")
            with h5py.File(f"{kind}.nxs", "r+") as file:
                del file["entry/cycle/v"]
                cycle, layout = file["entry/cycle"], h5py.VirtualLayout((100,), float)
                layout[:] = h5py.VirtualSource("private.h5", "secret", (100,))
                if kind == "link":
                    cycle["v"] = h5py.ExternalLink("private.h5", "/secret")
                elif kind == "raw":
                    cycle.create_dataset("v", (100,), float, external=[("private.raw", 0, 800)])
                else:
                    cycle.create_virtual_dataset("v", layout)
            with shakerd.Recording(f"{kind}.nxs") as run:
                with self.assertRaisesRegex(shakerd.FileError, f"{kind}.nxs: /entry/cycle/v is stored in another file"):
                    run.cycle["v"]
                self.assertEqual(len(run.cycle["x"]), len(run.cycle["phase"]))

    def test_table_for_pandas_has_units_and_errors(self):
        with shakerd.Campaign("points") as campaign:
            frame = campaign.measured.frame()
            self.assertEqual(frame.attrs["units"]["v_D"], "m/s")
            np.testing.assert_array_equal(frame["v_D_errors"], campaign.measured["v_D"].error)
            self.assertEqual(set(frame["outcome"]), {"measured"})

    def test_law_of_the_points(self):
        with shakerd.Campaign("points") as campaign:
            with unittest.mock.patch.dict(os.environ, SHAKERD=str(PROGRAM)):
                verdict = campaign.law()
            chosen = verdict["laws"][verdict["chosen"]]
            self.assertEqual((verdict["chosen"], verdict["refused"]), ("coulomb", False))
            self.assertIn("Coulomb describes the points", verdict["sentence"])
            self.assertLess(abs(chosen["mu"].value - 0.113), 4 * chosen["mu"].error)
            self.assertEqual(verdict["laws"]["dahl"]["parameters"]["s_0"].unit, "m")
            self.assertTrue(np.isnan(verdict["laws"]["unequal"]["mu"].value))  # not fitted
            mu = verdict["friction"]["mu"]
            self.assertGreaterEqual(len(mu), 6)
            np.testing.assert_array_less(abs(mu.value - 0.113), 4 * mu.error)
            with (unittest.mock.patch.dict(os.environ, SHAKERD="/none/shakerd"),
                  self.assertRaisesRegex(shakerd.FileError, "points/campaign.nxs: /none/shakerd law: .*No such file")):
                campaign.law()
            campaign.path = pathlib.Path("plan.toml")
            with (unittest.mock.patch.dict(os.environ, SHAKERD=str(PROGRAM)),
                  self.assertRaisesRegex(shakerd.FileError, "plan.toml: .*shakerd law: shakerd: plan.toml: not an HDF5 file")):
                campaign.law()

    def test_friction_of_one_run(self):
        with shakerd.Recording("run.nxs") as run, unittest.mock.patch.dict(os.environ, SHAKERD=str(PROGRAM)):
            verdict = run.law()
        twice = subprocess.run([PROGRAM, "law", "run.nxs", "./run.nxs"], capture_output=True, text=True)
        self.assertEqual((twice.returncode, "given twice" in twice.stderr), (2, True))
        v_R, mu = verdict["friction"]["v_R"], verdict["friction"]["mu"]
        self.assertTrue(v_R.value.min() < 0 < v_R.value.max())
        np.testing.assert_array_less(abs(mu.value - 0.113), 4 * mu.error)
        self.assertLess(mu.error.min(), 2e-3)

    def test_a_growing_file_opens_and_shows_new_rows(self):
        shutil.copy("run.nxs", "grown.nxs.part")
        with h5py.File("grown.nxs.part", "r+", libver="latest") as writer:
            grown = writer.create_dataset("entry/more", (1,), maxshape=(None,), dtype="f8")
            writer.swmr_mode = True
            with shakerd.Recording("grown.nxs.part") as run:
                grown.resize((3,))
                grown[:] = 2.0
                grown.flush()
                run.refresh()
                self.assertEqual(run.entry["more"][...].tolist(), [2.0, 2.0, 2.0])

    def test_wrong_files_are_refused_with_a_sentence(self):
        for path, opened, words in (("none.nxs", shakerd.Recording, "none.nxs: no such file; expected a recording"),
                                    ("plan.toml", shakerd.Recording, "cannot be read as HDF5"),
                                    ("points/campaign.nxs", shakerd.Recording, "no group entry/raw; expected a recording"),
                                    ("points/r001.nxs", shakerd.Campaign, None)):
            if words is None:
                opened(path).close()  # the campaign's folder is that of the file
                continue
            with self.assertRaisesRegex(shakerd.FileError, re.escape(words)):
                opened(path)
        shutil.copy("run.nxs", "newer.nxs")
        with h5py.File("newer.nxs", "r+") as file:
            file["entry/process"].attrs["schema"] = np.int64(99)
        with self.assertRaisesRegex(shakerd.FileError, "is of version 99, this shakerd.py reads up to"):
            shakerd.Recording("newer.nxs")

    def test_versions_are_those_of_the_program(self):
        with h5py.File("run.nxs") as run, h5py.File("points/campaign.nxs") as campaign:
            self.assertEqual(run["entry/process"].attrs["schema"], shakerd.RECORDING_SCHEMA)
            self.assertEqual(campaign["entry/process"].attrs["schema"], shakerd.CAMPAIGN_SCHEMA)

    def test_figure_and_control_chart(self):
        self.example("fig3a.py", "points", "fig3a.png")
        self.assertEqual(pathlib.Path("fig3a.png").read_bytes()[:4], b"\x89PNG")
        chart = self.example("mu_archive.py", ".")
        self.assertRegex(chart, r"points: mu_ac 0\.11\d+ \+- 0\.0\d+\n")
        self.assertIn("mean 0.11", chart)

    @contextlib.contextmanager
    def served(self):
        """A daemon's address, and the port of its instrument language."""
        serve = subprocess.Popen([PROGRAM, "serve", "--scene", "scene.toml", "--http-port", "0", "--scpi-port", "0",
                                  "--recordings", "."], stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True)
        try:
            line = serve.stdout.readline()
            yield re.search(r"http://\S+?:\d+", line).group(), int(re.search(r" port (\d+)", line).group(1))
        finally:
            serve.terminate()
            serve.communicate(timeout=30)

    def test_four_doors_refuse_in_the_same_words(self):
        """HTTP, Python and shakerctl word for word behind the name of the field; SCPI where the bench refuses, and with a
        standard number where the syntax of its values differs."""
        same_in_scpi = 0
        with self.served() as (url, port), socket.create_connection(("127.0.0.1", port)) as link:
            bench, lines = shakerd.Bench(url).ready(), link.makefile("rw", newline="\n")
            bench.wait("idle")
            self.assertGreaterEqual(len(WRONG), 30)
            for name, body, words, command in WRONG:
                with self.subTest(order=name, body=body):
                    with self.assertRaises(shakerd.BenchError) as refused:
                        bench.order(name, **body)
                    http = str(refused.exception)
                    shell = subprocess.run([PROGRAM.parent / "shakerctl", *words, "--at", url], text=True, check=False,
                                           capture_output=True)
                    self.assertIn(shell.returncode, (1, 2))
                    self.assertEqual(re.sub(r"^shakerctl: (--?\w+|[A-Z]+) ", "", shell.stderr).removeprefix("shakerctl: ").strip(),
                                     re.sub(rf"^({'|'.join(body)}) ", "", http) if shell.returncode == 2 else http)
                    if command is None:
                        continue
                    lines.write(f"*CLS;{command}\n*OPC?\nSYST:ERR?\n")
                    lines.flush()
                    lines.readline()
                    number, told = lines.readline().strip().split(",", 1)
                    if number in ("-220", "-221"):
                        same_in_scpi += 1
                        self.assertIn(http[:150], told.replace('""', '"').replace(r"\xc2\xb0", "°"))
                    self.assertIn(number, ("-104", "-131", "-220", "-221", "-222", "-224"))
            bench.close()
        self.assertGreaterEqual(same_in_scpi, 12)

    def test_a_bench_is_driven(self):
        with self.served() as (url, _):
            bench = shakerd.Bench(url).ready()
            bench.wait("idle")
            with self.assertRaisesRegex(shakerd.BenchError, "no measurement"):
                bench.result
            with self.assertRaisesRegex(shakerd.BenchError, r"^gamma_mps2 .*allowed: 0\.01 to 980 m/s"):
                bench.drive(gamma=98100)
            sweep = self.example("live_sweep.py", url)
            self.assertEqual(len(re.findall(r"^phi -?\d\.\d+ rad: v_D [+-]\d+\.\d+ \+- 0\.\d+ mm/s$", sweep, re.M)), 4)
            folder = bench.campaign(scan="phi", start=2.2, stop=2.3, steps=1, periods=5)
            with shakerd.Campaign(folder) as campaign:
                self.assertEqual(len(campaign.measured["v_D"]), 2)
            bench.drive(phi=2.3)  # near the null: it hardly walks
            bench.start(periods=5)
            bench.wait("running", timeout=60)
            bench.abort()
            with self.assertRaisesRegex(shakerd.BenchError, "stopped by the operator"):
                bench.wait("idle")
            bench.clear()
            bench.wait("idle")
        with self.assertRaisesRegex(shakerd.BenchError, "no answer"):
            bench.state
        bench.close()


if __name__ == "__main__":
    unittest.main(argv=sys.argv[:1])
