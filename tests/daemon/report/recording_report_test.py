#!/usr/bin/python3
"""Tests of daemon/report/campaign: single recordings.    /usr/bin/python3 tests/daemon/report/recording_report_test.py"""
import unittest

import h5py
import numpy as np

from small_campaigns import HOSTILE, G, ReportTest, Tags, points_of, report


def write_recording(path, measured=2, title="a run", reason="", kind="run"):
    """A recording with finished measurements; none: that of a run that ended before. measured None: version 1, one result."""
    phase, count = np.arange(50) / 50, measured or 0
    one = lambda k: dict(v_D=1e-3 * (k + 1), D=5e-5, gamma=G, phi=0.5, rho=0.5, frequency=20.0, efficiency=0.1)
    with h5py.File(path, "w") as f:
        e = f.create_group("entry")
        put = lambda name, data: e.create_dataset(name, data=data)
        text = lambda name, *lines: put(name, np.array([t.encode() for t in lines], dtype="S512"))
        for name, line in (("title", title), ("start_time", "2026-11-25T18:45:30+00:00"), ("process/kind", kind),
                           ("process/program", "shakerd"), ("process/version", "0.1.0"), ("process/not_reduced", reason),
                           ("process/config_text", "periods = 40"), ("process/rig_text", HOSTILE)):
            put(name, np.bytes_(line.encode()))
        put("events/t", [0.5]), text("events/state", "run"), text("events/text", HOSTILE), text("trips/words", *[HOSTILE] * (count == 0))
        text("results/notes/text"), text("measured/notes/text", "frames were lost"), put("measured/notes/measurement", [1.0])
        empty = np.nan if measured == 0 else 1.0
        for name, value in one(max(count - 1, 0)).items():
            put(f"results/{name}", value * empty), put(f"results/{name}_errors", value * 1e-4 * empty)
            put(f"measured/results/{name}", [one(k)[name] for k in range(count)])
            put(f"measured/results/{name}_errors", [one(k)[name] * 1e-4 for k in range(count)])
        for name, value in dict(asked_gamma=G, asked_phi=0.5, asked_rho=0.5, asked_frequency=20.0).items():
            put(f"measured/{name}", np.full(count, value))
        put("measured/measurement", np.arange(count) + 1.0), put("measured/results/measurement", np.arange(count) + 1.0)
        for name in ("x", "x_errors", "v", "v_errors", "v_base", "phase"):
            values = phase if name == "phase" else 1e-3 * np.sin(2 * np.pi * phase)
            put(f"cycle/{name}", values if measured != 0 else []), put(f"measured/cycle/{name}", np.tile(np.abs(values), count))
        put("measured/cycle/measurement", np.repeat(np.arange(count) + 1.0, 50))
        for name, value in (("from", 0.9), ("to", 1.1), ("errors", 0.01)):
            put(f"stick/{name}", []), put(f"measured/stick/{name}", [value])
        put("measured/stick/measurement", [1.0]), put("truth/v_D", 1.001e-3)
        if measured is None:
            del e["measured"]
    return path


class RecordingTest(ReportTest):
    def test_recordings_on_one_page(self):
        one, two = write_recording(self.folder / "r1.nxs", 7, HOSTILE), write_recording(self.folder / "r2.nxs", None)
        out = self.folder / "out"
        self.assertEqual(self.run_main(one, two, "-o", out)[0], 0)
        text = (out / "report.html").read_text()
        self.assertNotIn("script", Tags(text).tags)
        for part in ("r1 #7", "7.0000(7)", "0.900 to 1.100 ± 0.010", "1.001", "6 of the 8 measurements", "frames were lost", "periods = 40"):
            self.assertIn(part, text)
        self.assertEqual(len(list(out.iterdir())), 1 + 3 * len(report.RECORDING_FIGURES))

    def test_missing_results_are_said_in_words(self):
        for name, reason in (("a", "too few periods"), ("b", "")):
            path = write_recording(self.folder / f"{name}.nxs", 0, reason=reason, kind="trip")
            self.assertEqual(self.run_main(path, "-o", self.folder / name)[0], 0)
            text = (self.folder / name / "report.html").read_text()
            for part in ("No recording has results", f"No results: {reason or 'no measurement was finished'}.", "&lt;script&gt;",
                         "Not drawn: no recording has an averaged period", "2 s before a limit"):
                self.assertIn(part, text)

    def test_refuses_damage_and_mixtures(self):
        path, out = write_recording(self.folder / "r.nxs"), self.folder / "out"
        campaign = self.write("campaign", points_of((1,), (0,)))
        for words in ([path, campaign], [campaign, path], [path, "--fits", path]):
            status, _, err = self.run_main(*words, "-o", out)
            self.assertEqual((status, "a single recording; expected recordings alone" in err), (2, True), err)
        for spoiled, word in (("measured/results/v_D", "damaged or not a recording"), ("cycle/x", "differ in length"),
                              ("events", "no group /entry/events")):
            path = write_recording(self.folder / "r.nxs")
            with h5py.File(path, "a") as f:
                del f[f"entry/{spoiled}"]
                if word.startswith("differ"):
                    f[f"entry/{spoiled}"] = [1.0]
            status, _, err = self.run_main(path, "-o", out)
            self.assertEqual((status, word in err, out.exists()), (2, True, False), err)


class LinkTest(ReportTest):
    def test_replaces_links_in_the_output_folder(self):
        out, mine = self.folder / "out", self.folder / "mine"
        out.mkdir()
        mine.write_text("untouched")
        for name in ("report.html", ".report.html.part", "period_x.svg", "period_v.png", ".period_v.png.part"):
            (out / name).symlink_to(mine)
        self.assertEqual(self.run_main(write_recording(self.folder / "r.nxs"), "-o", out)[0], 0)
        self.assertEqual(mine.read_text(), "untouched")
        self.assertFalse(any(path.is_symlink() for path in out.iterdir()))


if __name__ == "__main__":
    unittest.main()
