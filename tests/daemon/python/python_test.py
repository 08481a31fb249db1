#!/usr/bin/python3
"""Tests of daemon/python: doc-tests on real files, examples, a bench on call.    SHAKER_BUILD=build/dev PROGRAM"""
import doctest
import os
import pathlib
import re
import shutil
import subprocess
import sys
import tempfile
import unittest

ROOT = pathlib.Path(__file__).resolve().parents[3]
sys.path.insert(0, str(ROOT / "daemon/python"))

import h5py
import numpy as np
import shakerd

PROGRAM = pathlib.Path(os.environ.get("SHAKER_BUILD", ROOT / "build/dev")).resolve() / "shakerd"
SCENE = "[top]\npositions = 1\n[side]\npositions = 1\n"
PLAN = '[[series]]\ngamma = "1g"\nphi = {from = "0deg", to = "180deg", steps = 3}\nperiods = 10\n'


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

    def test_a_bench_is_driven(self):
        serve = subprocess.Popen([PROGRAM, "serve", "--scene", "scene.toml", "--http-port", "0", "--scpi-port", "0",
                                  "--recordings", "."], stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True)
        try:
            url = re.search(r"http://\S+?:\d+", serve.stdout.readline()).group()
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
        finally:
            serve.terminate()
            serve.communicate(timeout=30)
        with self.assertRaisesRegex(shakerd.BenchError, "no answer"):
            bench.state
        bench.close()


if __name__ == "__main__":
    unittest.main(argv=sys.argv[:1])
