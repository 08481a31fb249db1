"""Tests of daemon/report/campaign: the curves are of the law that the points show. They run with report_test.py."""
import numpy as np

from small_campaigns import MU, G, ReportTest, fits_of, points_of

import drawing
import figures_cycles
import figures_drift
import figures_friction
import paper_numbers
import sources
import walker_law

WITH_CURVES = (figures_cycles.fig_2a, figures_cycles.fig_2c, figures_cycles.fig_2d, figures_drift.fig_2b, figures_drift.fig_3a,
               figures_drift.fig_3b, figures_drift.fig_4)


class CurvesTest(ReportTest):
    def with_verdict(self, law, parameters, refused=False, **row):
        laws = [dict(name=law, words=f"{law} in words", mu=0.13, mu_error=1e-4, **row,
                     parameters=[dict(name=name, unit="1", value=value, error=None) for name, value in parameters.items()])]
        verdict = dict(chosen=law, refused=refused, sentence="a sentence", laws=laws)
        name = f"{law} {refused} {len(row)}"
        points = points_of((0.5, 0.7, 1), np.radians([0, 30, 60, 90, 120, 150]))
        a = self.analysis(name, points, given={**fits_of(), "verdict": verdict})
        return a, sources.sources_of([a])[0][0]

    def words_of(self, function, source):
        """The texts of a figure."""
        figure = function([source])
        found = {text.get_text() for text in figure.findobj(drawing.plt.Text)}
        drawing.plt.close(figure)
        return " / ".join(sorted(found))

    def test_curves_are_of_the_law_that_holds(self):
        gamma, phi = np.array([0.5 * G]), np.array([0.0])
        drift = lambda *mu, **options: walker_law.settle(walker_law.biharmonic(gamma, phi), *mu, **options).v_D[0]
        coulomb = drift(0.13)
        for law, parameters, expected in (
                ("static", {"mu_s/mu_k": 2.0}, drift(0.13, 0.26)),
                ("viscous", {"c": 3.5}, drift(0.13, viscous=3.5)),
                ("logarithmic", {"B": 0.05}, drift(0.13, law="logarithmic", log_share=0.05)),
                ("dahl", {"s_0": 2e-5}, drift(0.13, law="dahl", presliding=2e-5)),
                ("dahl_viscous", {"s_0": 2e-5, "c": 3.5}, drift(0.13, law="dahl", presliding=2e-5, viscous=3.5)),
                ("stribeck", {"mu_s/mu_k": 1.5, "v_s": 0.02}, drift(0.13, 0.195, law="stribeck", stribeck=0.02)),
                ("unequal", {"mu backwards/forwards": 1.1}, drift(0.13, backward=1.1)),
                ("vertical", {"a_z/a_B in phase": 0.03, "a_z/a_B a quarter late": 0.04}, drift(0.13, vertical=0.03 - 0.04j)),
                ("time", {"excess": 0.5, "its time": 300.0}, coulomb), ("place", {"slope": 3.0}, coulomb)):
            with self.subTest(law=law):
                _, source = self.with_verdict(law, parameters)
                self.assertEqual(source.law_drift(gamma, phi)[0][0], expected)
                self.assertEqual(abs(expected - coulomb) > 1e-6, law not in ("time", "place"))
                self.assertEqual(source.law_words, f"{law} in words, mu = 0.13000(10)")

    def test_velocity_and_legends_are_of_that_law(self):
        a, source = self.with_verdict("dahl", {"s_0": 2e-5})
        v, x = figures_cycles.law_cycle(source, source.setting.rows[0])
        change = np.diff(v)  # an elastic contact has no kink
        self.assertLess(np.max(np.abs(np.diff(change))), 0.3 * np.max(np.abs(change)))
        self.assertAlmostEqual(x[-1], source.law_drift(np.array([0.5 * G]), np.array([0.0]))[0][0] / 20, delta=1e-8)
        for function in WITH_CURVES:
            words = self.words_of(function, source)
            self.assertIn("dahl in words", words)
            self.assertNotIn("exact law", words)
        self.assertIn("are those of this law.", self.page_of([a]))
        self.assertIn("those of this law with the mu at the mean place.", self.page_of([self.with_verdict("place", {"slope": 3.0})[0]]))

    def test_no_curve_is_exact_where_no_law_holds(self):
        for more in (dict(refused=True), dict(value=None)):  # refused; without its parameter
            a, source = self.with_verdict("dahl", {"s_0": more.get("value", 2e-5)}, refused="refused" in more)
            for function in WITH_CURVES:
                words = self.words_of(function, source)
                self.assertNotIn("exact law", words)
                self.assertNotIn("dahl in words", words)
                self.assertIn("Coulomb's law, refused by the data", words)
            self.assertNotEqual(source.line, drawing.LINES[0])
            middle, low, high = source.law_drift(np.array([G]), np.array([0.0]))
            self.assertEqual(low, high)
            figure = figures_friction.fig_friction([source])
            self.assertEqual([line.get_linestyle() for line in figure.axes[0].lines if len(line.get_xdata()) == 200], [])
            drawing.plt.close(figure)
            self.assertIn("are those of Coulomb's law with mu_ac, which the data refuse.", self.page_of([a]))

    def test_events_of_another_law_have_no_truth(self):
        a = self.analysis("scene", points_of((0.5, 1), (0,)))
        for walker, known in (({"mu_k": MU}, True), ({"mu_k": MU, "law": "dahl"}, False), ({"mu_k": MU, "viscous_per_s": 2}, False)):
            a.campaign.scene = {"walker": walker}
            row = next(r for r in paper_numbers.paper_rows(a) if r.quantity.startswith("v_R = 0"))
            self.assertEqual(np.isfinite(row.truth), known)

    def test_no_duration_of_a_flip_is_stated(self):
        a = self.analysis("flips", points_of((1, 2), (0,)))
        self.assertFalse([r for r in paper_numbers.paper_rows(a) if "flip" in r.quantity])
