#!/usr/bin/python3
"""Tests of daemon/report/campaign: pages and figures of small campaigns.    /usr/bin/python3 tests/daemon/report/report_test.py"""
import contextlib
import dataclasses
import html.parser
import io
import json
import os
import pathlib
import re
import subprocess
import sys
import tempfile
import unittest
import warnings

os.environ.setdefault("MPLBACKEND", "Agg")
os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

import h5py  # noqa: E402
import numpy as np  # noqa: E402

ROOT = pathlib.Path(__file__).resolve().parents[3]
os.environ["SHAKERD"] = str(pathlib.Path(os.environ.get("SHAKER_BUILD", ROOT / "build/dev")).resolve() / "shakerd")
SCRIPTS = ROOT / "daemon/report/campaign"
sys.dont_write_bytecode = True
sys.path.insert(0, str(SCRIPTS))

import campaign_file  # noqa: E402
import coulomb_law  # noqa: E402
import drawing  # noqa: E402
import figures_drift  # noqa: E402
import figures_friction  # noqa: E402
import page  # noqa: E402
import paper_numbers  # noqa: E402
import report  # noqa: E402
import sources  # noqa: E402

G, MU, Q = 9.8, 0.12, 16
figures_drift.PHI = np.linspace(0, 2 * np.pi, 13)  # coarse curves are quick
figures_drift.gamma_range = lambda found: sources.gamma_range(found, 9)
HOSTILE = '<script>alert(1)</script> $\\frac{1}{0$ & "quoted" \x01 _x'


def points_of(gammas, phis, series="2b", frequency=20.0, rho=0.5, overtones=()):
    """Set-points and their mirror partners, as dictionaries of asked values."""
    return [dict(series=series, frequency=frequency, gamma=g * G, rho=rho, phi=phi + side, overtones=overtones)
            for g in gammas for phi in phis for side in (0, np.pi)]


def write_campaign(folder, points, title="a plan", outcomes=None, noise=1e-7, spoil=None, journal=(), mu=MU):
    """campaign.nxs of a walker that obeys the exact law with MU. spoil: called with the open /entry at the end."""
    folder.mkdir(parents=True, exist_ok=True)
    n, phase = len(points), np.arange(100) / 100
    column = lambda name: np.array([p[name] for p in points], float)
    amplitude, angle = np.zeros((n, Q)), np.zeros((n, Q))
    for k, p in enumerate(points):
        amplitude[k, :2], angle[k, 1] = (p["gamma"] * p["rho"], p["gamma"] * (1 - p["rho"])), p["phi"]
        for q, share, at in p["overtones"]:
            amplitude[k, q - 1], angle[k, q - 1] = share * p["gamma"], at
    drives = coulomb_law.Drives(column("frequency"), np.arange(1, Q + 1), amplitude, angle)
    motion = coulomb_law.settle(drives, mu)
    v = np.array([coulomb_law.velocity_over_period(drives, motion, k, mu, phase) for k in range(n)]).reshape(n, 100)
    measured = np.array([(outcomes or {}).get(k, "measured") == "measured" for k in range(n)], bool)
    blank = lambda a: np.where(measured.reshape(-1, *[1] * (np.ndim(a) - 1)), a, np.nan)
    v_D = motion.v_D + noise * np.random.default_rng(1).standard_normal(n)
    rms = np.sqrt(np.sum((amplitude / (2 * np.pi * column("frequency")[:, None] * np.arange(1, Q + 1)))**2, 1) / 2)
    with h5py.File(folder / "campaign.nxs", "w") as f:
        e = f.create_group("entry")
        put = lambda name, data: e.create_dataset(name, data=data)
        texts = lambda name, values: e.create_dataset(name, data=np.array([t.encode() for t in values], dtype="S512"))
        for name, text in (("title", title), ("process/kind", "campaign"), ("process/config_text", f'title = "{title}"'),
                           ("process/program", "shakerd"), ("process/version", "0.1.0")):
            put(name, np.bytes_(text.encode()))
        ones = np.ones(n)
        numbers = dict(point=np.arange(1, n + 1), repeat=ones, partner=[k + 2 if k % 2 == 0 else k for k in range(n)],
                       asked_frequency=column("frequency"), asked_gamma=column("gamma"), asked_rho=column("rho"),
                       asked_phi=column("phi"), v_D=blank(v_D), v_D_errors=blank(noise * ones), frequency=blank(column("frequency")),
                       gamma=blank(column("gamma")), gamma_errors=blank(1e-6 * ones), rho=blank(column("rho")),
                       phi=blank(column("phi")), phi_errors=blank(1e-6 * ones), v_rms=blank(rms),
                       efficiency=blank(abs(v_D) / rms), efficiency_errors=blank(1e-5 * ones), true_v_D=blank(motion.v_D),
                       chi2=np.nan * ones, periods=blank(40 * ones))
        for name, data in numbers.items():
            put(f"points/{name}", np.asarray(data, float))
        texts("points/series", [p["series"] for p in points])
        texts("points/outcome", [(outcomes or {}).get(k, "measured") for k in range(n)])
        texts("points/reason", ["" if m else HOSTILE for m in measured])
        for name, data in dict(amplitude=blank(amplitude), phase=blank(angle), asked_amplitude=amplitude, asked_phase=angle).items():
            put(f"harmonics/{name}", data)
        put("harmonics/q", np.arange(1.0, Q + 1)), put("cycle/phase", phase)
        x = np.cumsum(v, 1) / 100 / column("frequency")[:, None]
        for name, data in dict(x=x - x[:, :1], x_errors=v * 0 + 1e-7, v=v, v_errors=v * 0 + 1e-4,
                               v_base=np.array([drives.velocity(k, phase) for k in range(n)]).reshape(n, 100)).items():
            put(f"cycle/{name}", blank(data))
        rest = [(k + 1, *i) for k in range(n) if measured[k] for i in coulomb_law.stick_intervals(motion, k)]
        for j, name in enumerate(("point", "from", "to")):
            put(f"stick/{name}", np.array([r[j] for r in rest], float))
        put("stick/errors", np.full(len(rest), 0.001))
        put("passes/point", np.arange(1.0, n + 1)), put("passes/pass", ones)
        texts("passes/how", ["complete"] * n), texts("passes/reason", [""] * n)
        if spoil:
            spoil(e)
    (folder / "journal.jsonl").write_text("".join(json.dumps(j) + "\n" for j in journal) + "not an entry\n")


def fits_of(law=(), mu=MU):
    """As of `shakerd mu --json`; law: (point, v_D, z)."""
    at = lambda name, value, gamma, **more: dict(name=name, value=value, error=1e-3, gamma_mps2=gamma * G, points=8, **more)
    return {"fits": [dict(name="mu_ac", value=mu, error=1e-6, unit="1", chi2=12, freedom=6, points=7),
                     dict(name="mu_ns", value=0.0925, error=1e-3, truth=0.0924, points=3), dict(name="mu_k", value=None, note=HOSTILE),
                     at("v_D*", 0.0105, 0.68, truth=0.0106, series="3a"), at("Theta*", 0.86, 0.68, series="3a"),
                     at("phi_0", 2.46, 0.68), at("phi_0", 2.20, 1), at("phi_0", 1.91, 2),
                     dict(name="gamma of reversal", value=7.7, error=1e-3, phi_rad=np.radians(135), unit="m/s^2")],
            "budgets": {"mu_ac": [{"source": "small<i>", "share": 3e-4}, {"source": "large", "share": 4e-4}]},
            "friction": [dict(v_R_mps=v, mu=mu + 0.01 * abs(v), mu_error=1e-3, pieces=5) for v in (-0.2, -0.01, 0.01, 0.2)],
            "points": [dict(point=n, law_v_D_mps=v, z=z) for n, v, z in law]}


class Tags(html.parser.HTMLParser):
    def __init__(self, text):
        super().__init__()
        self.tags, self.links = [], []
        self.feed(text)

    def handle_starttag(self, tag, attributes):
        self.tags.append(tag)
        self.links += [v for k, v in attributes if k in ("src", "href")]


class ReportTest(unittest.TestCase):
    def setUp(self):
        self.folder = pathlib.Path(self.enterContext(tempfile.TemporaryDirectory()))
        self.enterContext(warnings.catch_warnings())
        warnings.filterwarnings("error", category=RuntimeWarning)

    def write(self, name, points, **more):
        write_campaign(self.folder / name, points, **more)
        return self.folder / name

    def analysis(self, name, points, given=None, **more):
        return paper_numbers.analyse(campaign_file.read_campaign(self.write(name, points, **more)), given or {})

    def figures(self, analyses):
        """Names of the figures that are drawn, and sentences of those that are not."""
        drawn, missing = [], []
        found, _ = sources.sources_of(analyses)
        for name, module, function, *_ in report.FIGURES:
            try:
                figure = getattr(__import__(module), function)(found)
                figure.draw_without_rendering()
                drawing.plt.close(figure)
                drawn.append(name)
            except drawing.Missing as reason:
                missing.append(str(reason))
        return drawn, missing

    def page_of(self, analyses):
        return page.page(analyses, [], [], [paper_numbers.paper_rows(a) for a in analyses])

    def run_main(self, *words):
        out, err = io.StringIO(), io.StringIO()
        with contextlib.redirect_stdout(out), contextlib.redirect_stderr(err):
            status = report.main([str(w) for w in words])
        return status, out.getvalue(), err.getvalue()


class LawTest(unittest.TestCase):
    def test_agrees_with_the_reference(self):
        cases = json.loads((ROOT / "tests/golden/physics_reference.json").read_text())["cases"]
        checked = 0
        for case in cases:
            p, a = case["params"], case["params"]["base_accel"]
            if p["vertical_accel"] or not a:
                continue
            d = coulomb_law.Drives(np.array([p["f_hz"]]), np.array([h["q"] for h in a]), np.array([[h["a"] for h in a]]),
                                   np.array([[h["phase"] for h in a]]))
            found = coulomb_law.settle(d, p["mu_k"], p["mu_s"], np.radians(p["tilt_deg"]))
            self.assertAlmostEqual(found.v_D[0], case["answer"]["v_D"], delta=1e-12, msg=case["name"])
            rest = sum(end - start for start, end in coulomb_law.stick_intervals(found, 0))
            self.assertAlmostEqual(rest, case["answer"]["stick_fraction"], delta=1e-9, msg=case["name"])
            checked += 1
        self.assertGreaterEqual(checked, 10)

    def test_null_phase(self):
        theta = coulomb_law.coulomb_theta(np.array([3, 10, 30]) * MU * G, MU)
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
        law = sources.sources_of([a])[0][0].law(np.array([G]), np.array([0.0]))
        self.assertAlmostEqual(law[2][0] - law[0][0], coulomb_law.settle(coulomb_law.biharmonic(G, 0), MU * 1.001).v_D[0] - law[0][0])

    def test_law_that_holds_is_told_before_a_refused_mu(self):
        laws = [dict(name="coulomb", words="Coulomb", mu=0.12, mu_error=1e-6, parameters=[], chi2=1e4, freedom=5, score=1e4, reason=""),
                dict(name="viscous", words="Coulomb and viscous " + HOSTILE, mu=0.113, mu_error=1e-4, chi2=4, freedom=4, score=9,
                     parameters=[dict(name="c", unit="1/s", value=3.5, error=0.01)], reason=""),
                dict(name="unequal", words="unequal", mu=None, mu_error=None, parameters=[], reason="needs the tilt by gravity")]
        verdict = dict(chosen="viscous", refused=False, sentence="viscous describes the points", laws=laws)
        a = self.analysis("viscous", points_of((0.5, 1, 2), np.radians([0, 45, 90])), given={**fits_of(), "verdict": verdict})
        text = self.page_of([a])
        self.assertIn("viscous describes the points. The curves in the figures are those of Coulomb's law", text)
        self.assertIn("c 3.500(10) 1/s", text)
        self.assertIn("needs the tilt by gravity", text)
        self.assertNotIn("<script>", text)
        v = np.array([-0.1, 0.1])
        self.assertTrue(np.allclose(figures_friction.mu_of_law(a.fits, v, 9.8), 0.113 + 3.5 * 0.1 / 9.8))
        self.assertIsNone(figures_friction.mu_of_law(dataclasses.replace(a.fits, verdict={**verdict, "refused": True}), v, 9.8))

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
