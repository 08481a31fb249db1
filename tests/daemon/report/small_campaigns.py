"""Small campaigns for the tests of the report."""
import contextlib
import html.parser
import io
import json
import os
import pathlib
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
import drawing  # noqa: E402
import figures_drift  # noqa: E402
import page  # noqa: E402
import paper_numbers  # noqa: E402
import report  # noqa: E402
import sources  # noqa: E402
import walker_law  # noqa: E402

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
    drives = walker_law.Drives(column("frequency"), np.arange(1, Q + 1), amplitude, angle)
    motion = walker_law.settle(drives, mu, phases=100)
    v = motion.v.reshape(n, 100)
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
        rest = [(k + 1, *i) for k in range(n) if measured[k] for i in walker_law.stick_intervals(motion, k)]
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
