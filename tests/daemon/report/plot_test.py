#!/usr/bin/python3
"""Tests of daemon/report/plot: its messages of error.    /usr/bin/python3 tests/daemon/report/plot_test.py"""
import pathlib
import subprocess
import tempfile
import unittest

import h5py
import numpy as np

PLOT = pathlib.Path(__file__).resolve().parents[3] / "daemon/report/plot"


class PlotTest(unittest.TestCase):
    def setUp(self):
        self.folder = pathlib.Path(self.enterContext(tempfile.TemporaryDirectory()))

    def refused(self, *arguments):
        """The one line that a refused call prints."""
        done = subprocess.run(["/usr/bin/python3", PLOT, *arguments], capture_output=True, text=True, cwd=self.folder)
        self.assertEqual(done.returncode, 1, done)
        self.assertEqual(done.stdout, "")
        lines = done.stderr.splitlines()
        self.assertEqual(len(lines), 1, done.stderr)
        self.assertTrue(lines[0].startswith("plot: "), lines)
        return lines[0]

    def test_no_arguments(self):
        self.assertIn("expected RUN.nxs PICTURE.png, got 0 names", self.refused())
        self.assertIn("got 3 names", self.refused("a", "b", "c"))

    def test_no_file(self):
        self.assertIn("missing.nxs: cannot be read as HDF5", self.refused("missing.nxs", "out.png"))

    def test_picture_as_input(self):
        (self.folder / "in.png").write_bytes(b"\x89PNG\r\n\x1a\n" + bytes(2000))
        self.assertIn("in.png: cannot be read as HDF5", self.refused("in.png", "out.png"))

    def test_other_hdf5_file(self):
        with h5py.File(self.folder / "other.nxs", "w") as f:
            f["data"] = np.arange(3)
        self.assertIn("has no entry/title", self.refused("other.nxs", "out.png"))
        with h5py.File(self.folder / "half.nxs", "w") as f:
            f["entry/title"] = np.array(b"a run")
        self.assertIn("half.nxs: ", self.refused("half.nxs", "out.png"))
        self.assertIn("half.nxs: ", self.refused("--identification", "half.nxs", "out.png"))
        self.assertFalse((self.folder / "out.png").exists())


if __name__ == "__main__":
    unittest.main()
