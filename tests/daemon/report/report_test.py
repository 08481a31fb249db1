#!/usr/bin/python3
"""Tests of daemon/report/campaign: pages and figures of small campaigns.    /usr/bin/python3 tests/daemon/report/report_test.py"""
import json
import re
import subprocess
import sys
import unittest

import h5py
import numpy as np

from small_campaigns import HOSTILE, MU, ROOT, SCRIPTS, G, ReportTest, Tags, fits_of, points_of
from curves_test import CurvesTest  # noqa: F401  runs with these tests

import drawing
import figures_friction
import paper_numbers
import report
import sources
import walker_law


class LawTest(unittest.TestCase):
    def test_agrees_with_the_reference(self):
        cases = json.loads((ROOT / "tests/golden/physics_reference.json").read_text())["cases"]
        checked = 0
        for case in cases:
            p, a = case["params"], case["params"]["base_accel"]
            if p["vertical_accel"] or not a:
                continue
            d = walker_law.Drives(np.array([p["f_hz"]]), np.array([h["q"] for h in a]), np.array([[h["a"] for h in a]]),
                                   np.array([[h["phase"] for h in a]]))
            found = walker_law.settle(d, p["mu_k"], p["mu_s"], np.radians(p["tilt_deg"]))
            self.assertAlmostEqual(found.v_D[0], case["answer"]["v_D"], delta=1e-12, msg=case["name"])
            rest = sum(end - start for start, end in walker_law.stick_intervals(found, 0))
            self.assertAlmostEqual(rest, case["answer"]["stick_fraction"], delta=1e-9, msg=case["name"])
            checked += 1
        self.assertGreaterEqual(checked, 10)

    def test_null_phase(self):
        theta = walker_law.null_theta(np.array([3, 10, 30]) * MU * G, walker_law.Law(MU))
        np.testing.assert_allclose(theta, [1.43174, 0.53837, 0.19275], atol=1e-5)


class CampaignTest(ReportTest):
    def test_whole_report_of_hostile_campaigns(self):
        points = points_of((0.5, 1, 2), np.radians([0, 45, 90, 135]))
        journal = [{"what": "campaign", "change": "paused", "reason": HOSTILE, "time": "2026-11-25T18:45:30+00:00"},
                   {"what": "point ended", "outcome": "failed", "point": 3, "reason": HOSTILE}]
        one = self.write("<b>$one$", points, title=HOSTILE, outcomes={3: "failed", 23: "not begun"}, journal=journal)
        two = self.write("two", points, mu=0.2)
        (one / "bench.png").write_bytes(b"\x89PNG\r\n\x1a\n")
        given = self.folder / "fits.json"
        given.write_text(json.dumps([{**fits_of(), "fits": [{"name": HOSTILE, "value": 0.1}, *fits_of()["fits"]]}, fits_of(mu=0.2)]))
        out = self.folder / "out"
        status, printed, _ = self.run_main(one, two, "-o", out, "--fits", given)
        self.assertEqual(status, 0)
        self.assertIn("mu_ac", printed)
        text = (out / "report.html").read_text()
        tags = Tags(text)
        self.assertFalse({"script", "b$one$", "i"} & set(tags.tags))
        self.assertGreater(text.count("&lt;script&gt;alert(1)&lt;/script&gt;"), 4)
        self.assertLess(text.index("large"), text.index("small&lt;i&gt;"))
        self.assertTrue(all(link.startswith(("data:", "#")) for link in tags.links))
        self.assertIn("Residuals. Not drawn: it needs mu_ac", text)
        drawn = [name for name, *_ in report.FIGURES if name != "residuals"]
        self.assertEqual(len([link for link in tags.links if link.startswith("data:image/svg")]), len(drawn))
        for name in drawn:
            for kind in drawing.KINDS:
                self.assertGreater((out / f"{name}.{kind}").stat().st_size, 1000)
        self.assertEqual(len(list(out.iterdir())), 1 + 3 * len(drawn))

    def test_fits_reach_figures_and_tables(self):
        points = points_of((0.5, 0.68, 1, 2), np.radians([0, 30, 60, 90, 115, 125, 135, 150]), "3a")
        a = self.analysis("exact", points, given=fits_of([(1, 0.003, 0.5), (2, -0.003, 3.5), (999, 0.0, 0.0)]))
        rows = {r.quantity: r for r in paper_numbers.paper_rows(a)}
        mu = rows["mu_ac: exact Coulomb law"]
        self.assertEqual((mu.ours, round(mu.error / MU, 9)), (MU, 5e-4))  # the error is that of the whole budget
        self.assertAlmostEqual(rows["v_D* at 0.68 g"].z, -0.1)
        self.assertAlmostEqual(rows["v_D reverses at phi = 3 pi/4, gamma"].ours, 7.7 / G)
        self.assertEqual(self.figures([a])[1], [])
        text = self.page_of([a])
        self.assertIn("chi2 2, 1 of 2 points beyond 3", text)
        self.assertIn("0.1200000(10)", text)
        law = sources.sources_of([a])[0][0].law_drift(np.array([G]), np.array([0.0]))
        self.assertAlmostEqual(law[2][0] - law[0][0], walker_law.settle(walker_law.biharmonic(G, 0), MU * 1.001).v_D[0] - law[0][0])

    def test_law_that_holds_is_told_before_a_refused_mu(self):
        laws = [dict(name="coulomb", words="Coulomb", mu=0.12, mu_error=1e-6, parameters=[], chi2=1e4, freedom=5, score=1e4, reason=""),
                dict(name="viscous", words="Coulomb and viscous " + HOSTILE, mu=0.113, mu_error=1e-4, chi2=4, freedom=4, score=9,
                     parameters=[dict(name="c", unit="1/s", value=3.5, error=0.01)], reason=""),
                dict(name="unequal", words="unequal", mu=None, mu_error=None, parameters=[], reason="needs the tilt by gravity")]
        verdict = dict(chosen="viscous", refused=False, sentence="viscous describes the points", laws=laws)
        a = self.analysis("viscous", points_of((0.5, 1, 2), np.radians([0, 45, 90])), given={**fits_of(), "verdict": verdict})
        text = self.page_of([a])
        self.assertIn("viscous describes the points. The curves in the figures are those of this law.", text)
        self.assertIn("c 3.500(10) 1/s", text)
        self.assertIn("needs the tilt by gravity", text)
        self.assertNotIn("<script>", text)
        v = np.array([-0.1, 0.1])
        self.assertTrue(np.allclose(figures_friction.mu_of_law(a.law, v, 9.8), 0.113 + 3.5 * 0.1 / 9.8))

    def test_without_fits_the_rest_is_drawn(self):
        drawn, missing = self.figures([self.analysis("bare", points_of((0.5, 1, 2), np.radians([0, 45, 90, 135])))])
        self.assertEqual(drawn, ["fig2a", "fig2b", "fig2c", "fig2d", "fig3a", "fig4"])
        self.assertTrue(all("shakerd mu" in m for m in missing))

    def test_empty_campaigns(self):
        for name, points, outcomes in (("none", [], {}), ("nothing measured", points_of((1,), (0, 1)),
                                                          {0: "failed", 1: "left out", 2: "not begun", 3: "in progress"})):
            a = self.analysis(name, points, outcomes=outcomes)
            text = self.page_of([a])
            self.assertIn("No point has a result", text)
            self.assertEqual(text.count('<td class="s">left out</td>'), 1 if points else 0)
        out = self.folder / "out"
        out.mkdir()
        (out / "fig2a.svg").write_text("of an earlier report")
        status, _, _ = self.run_main(self.folder / "none", "-o", out)
        self.assertEqual((status, [p.name for p in out.iterdir() if p.name != "fig2a.svg"]), (0, ["report.html"]))

    def test_interrupted_campaign(self):
        points = points_of((0.5, 1, 2), np.radians([0, 45, 90]))
        a = self.analysis("half", points, outcomes={7: "in progress", **{k: "not begun" for k in range(8, 18)}})
        self.assertEqual(len(a.settings[0].rows), 7)
        self.assertIn("10 points were not begun", self.page_of([a]))
        self.assertEqual(self.page_of([a]).count("<td class=\"s\">in progress</td>"), 1)
        self.figures([a])

    def test_one_point(self):
        a = self.analysis("one", points_of((1,), (0,))[:1])
        drawn, missing = self.figures([a])
        self.assertEqual(drawn, ["fig2a", "fig2c"])
        self.assertTrue(all(m.startswith("it needs") for m in missing))

    def test_several_frequencies_and_overtones(self):
        phis = np.radians([0, 60, 120])
        points = (points_of((0.5, 1, 2), phis) + points_of((0.5, 1, 2), phis, frequency=35.0)
                  + points_of((0.5, 1, 2), phis, overtones=((3, 0.05, 0.5),)))
        a = self.analysis("settings", points)
        self.assertEqual(sorted(len(s.rows) for s in a.settings), [18, 18, 18])
        self.assertTrue(a.settings[0].like_the_paper)
        self.assertIn("fig2b", self.figures([a])[0])
        self.assertIn("5 % of 3f", self.page_of([a]))

    def test_nan_everywhere(self):
        def spoil(entry):
            for path in ("points/v_D_errors", "points/phi_errors", "points/efficiency", "points/true_v_D", "cycle/v",
                         "cycle/x_errors", "stick/to", "harmonics/amplitude"):
                entry[path][...] = np.nan
        a = self.analysis("nan", points_of((0.5, 1, 2), np.radians([0, 45, 90, 135])), spoil=spoil)
        self.figures([a])
        self.page_of([a])

        def spoil_all(entry):
            for group in ("points", "cycle", "harmonics", "stick"):
                for data in entry[group].values():
                    if data.dtype.kind == "f":
                        data[...] = np.nan
        b = self.analysis("all nan", points_of((0.5, 1), (0, 1)), spoil=spoil_all)
        self.assertIn("is not a number", self.page_of([b]))
        self.assertEqual(self.figures([b])[0] if b.settings else [], [])


class RefusalTest(ReportTest):
    def assert_refused(self, words, *expected):
        status, _, err = self.run_main(*words, "-o", self.folder / "out")
        self.assertEqual(status, 2, err)
        for word in expected:
            self.assertIn(word, err)
        self.assertFalse((self.folder / "out").exists())

    def test_refuses_what_is_not_a_campaign(self):
        (self.folder / "empty").mkdir()
        self.assert_refused([self.folder / "empty"], "no campaign.nxs", "expected")
        self.assert_refused([self.folder / "missing"], "no such file", "expected")
        (self.folder / "text.nxs").write_text("no HDF5")
        self.assert_refused([self.folder / "text.nxs"], "cannot be read as HDF5", "expected")

    def test_refuses_damaged_tables(self):
        points = points_of((1,), (0, 1))
        missing = self.write("missing column", points, spoil=lambda e: e.__delitem__("points/v_D"))
        self.assert_refused([missing], "no column /entry/points/v_D")

        def shorten(entry):
            del entry["cycle/v"]
            entry["cycle/v"] = np.zeros((1, 3))
        self.assert_refused([self.write("short", points, spoil=shorten)], "shape (1, 3); expected (4, 100)")

        def link(entry):
            del entry["points/v_D"]
            entry["points/v_D"] = h5py.ExternalLink(str(self.folder / "short" / "campaign.nxs"), "/entry/points/v_D")
        self.assert_refused([self.write("link", points, spoil=link)], "stored in another file")

        def retype(entry):
            del entry["points/v_D"]
            entry["points/v_D"] = np.array([b"a"] * 4)
        self.assert_refused([self.write("text", points, spoil=retype)], "/entry/points/v_D")

    def test_refuses_bad_fits(self):
        good, fits = self.write("good", points_of((1,), (0,))), self.folder / "fits.json"
        for text, word in (("{", "not JSON"), ("[]", "fits of 0 campaigns"), ("[1]", "is not an object"),
                           ('{"points": [{}]}', '"points" is not a list'), ('{"fits": [1]}', "not a list"),
                           ('{"friction": [1]}', '"friction" is not a list'), ('{"verdict": 1}', '"verdict" is not'),
                           ('{"verdict": {"laws": [{"parameters": 1}]}}', '"verdict" is not'),
                           ('{"budgets": {"mu_ac": [{"source": 1}]}}', "budgets"), ('{"budgets": {"mu_ac": 3}}', "budgets")):
            fits.write_text(text)
            self.assert_refused([good, "--fits", fits], word)

    def test_exit_status_of_the_script(self):
        done = subprocess.run([sys.executable, SCRIPTS / "report.py", "nowhere", "-o", "out"], cwd=self.folder, text=True,
                              capture_output=True, check=False)
        self.assertEqual(done.returncode, 2)
        self.assertTrue(re.fullmatch(r"report: nowhere: no such file or folder; expected .*\n", done.stderr), done.stderr)


class TextTest(unittest.TestCase):
    def test_values_with_errors(self):
        for value, error, text in ((0.112979, 2.2e-6, "0.112979(2)"), (0.113, 1.5e-3, "0.1130(15)"), (14.5, 0.96, "14.5(10)"),
                                   (1234.0, 30.0, "1234(30)"), (0.5, np.nan, "0.5"), (np.nan, 1.0, "nan")):
            self.assertEqual(drawing.with_error(value, error), text)

    def test_angles(self):
        self.assertEqual([drawing.angle_name(np.radians(a)) for a in (0, 45, 90, 135, 180, 20)],
                         ["0", "π/4", "π/2", "3π/4", "π", "20°"])


if __name__ == "__main__":
    unittest.main()
