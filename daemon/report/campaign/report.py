#!/usr/bin/python3
"""Draws campaigns: the figures of the paper, fits, and the paper's numbers beside them, as one HTML page.

  report.py FOLDER_OR_FILE... -o OUT [--fits FILE.json] [--label NAME]...

FOLDER_OR_FILE  folder of a campaign, or its campaign.nxs; several are compared
-o OUT          folder, made when it is missing: report.html and each figure as SVG, PDF and PNG
--fits FILE     fits and budgets of another program, see README.md
--label NAME    name of a campaign in the legends, in the order of the campaigns; default: name of its folder

Needs python3-h5py and python3-matplotlib. Exit status: 0 done; 2 input refused, nothing was written.
"""
import argparse
import json
import os
import pathlib
import shutil
import sys
import tempfile

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")  # the arrays are small
sys.dont_write_bytecode = True  # the folder of the scripts may be read-only
sys.path.insert(0, os.path.dirname(os.path.abspath(__file__)))

MOST_CAMPAIGNS = 6

FIGURES = (  # name, module, function, title, caption
    ("fig2a", "figures_cycles", "fig_2a", "Fig. 2(a).", "Walk in one period, averaged. Lines: exact Coulomb law."),
    ("fig2b", "figures_drift", "fig_2b", "Fig. 2(b).", "Drift velocity against gamma. Bands: two errors of mu_ac."),
    ("fig2c", "figures_cycles", "fig_2c", "Fig. 2(c).", "Velocity in one period at phi = 0; shaded: the measured stick interval."),
    ("fig2d", "figures_cycles", "fig_2d", "Fig. 2(d).", "Velocity in one period at phi = pi/2; shaded: the measured stick interval."),
    ("fig3a", "figures_drift", "fig_3a", "Fig. 3(a).", "Drift velocity against phi."),
    ("fig3b", "figures_drift", "fig_3b", "Fig. 3(b).", "Null phase less pi/2 against gamma. Bands of the closed form: 95 %."),
    ("fig4", "figures_drift", "fig_4", "Fig. 4.", "Efficiency against gamma."),
    ("residuals", "figures_drift", "fig_residuals", "Residuals.", "Measured v_D less the exact law at the measured drive."))


def read_arguments(words):
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter, usage=argparse.SUPPRESS)
    parser.add_argument("campaigns", nargs="+", metavar="FOLDER_OR_FILE")
    parser.add_argument("-o", "--out", required=True)
    parser.add_argument("--fits")
    parser.add_argument("--label", action="append", default=[])
    return parser.parse_args(words)


def read_fits(path):
    from campaign_file import InputError
    if path is None:
        return {}
    try:
        given = json.loads(pathlib.Path(path).read_text(encoding="utf-8"))
    except OSError as error:
        raise InputError(f"{path}: {error.strerror}; expected a JSON file of fits") from None
    except ValueError as error:
        raise InputError(f"{path}: not JSON ({error}); expected a JSON file of fits") from None
    fits, budgets = (given.get("fits", []), given.get("budgets", {})) if isinstance(given, dict) else (None, None)
    if not isinstance(fits, list) or not all(isinstance(f, dict) for f in fits):
        raise InputError(f'{path}: "fits" is not a list of objects; expected {{"fits": [{{"name", "value", "error", ...}}]}}')
    lines = [line for b in budgets.values() for line in b] if isinstance(budgets, dict) and all(
        isinstance(b, list) for b in budgets.values()) else [None]
    if not all(isinstance(line, dict) and isinstance(line.get("share"), (int, float)) and "source" in line for line in lines):
        raise InputError(f'{path}: "budgets" is not an object of lists; expected {{"mu_ac": [{{"source": "gain", "share": 1e-5}}]}}')
    return given


def labels_of(paths, given):
    """Unique names: those of the options, then those of the folders."""
    from campaign_file import InputError
    if len(given) > len(paths):
        raise InputError(f"--label: {len(given)} names for {len(paths)} campaigns; expected one for each at most")
    names = []
    for k, path in enumerate(paths):
        place = pathlib.Path(path).resolve()
        name = given[k] if k < len(given) else (place.parent.name if place.is_file() else place.name) or "campaign"
        names.append(name if name not in names else f"{name} ({k + 1})")
    return names


def draw(sources, folder):
    """Figures into the folder; [(name, title, caption, SVG)]."""
    import importlib

    from drawing import Missing, missing_figure, save
    drawn = []
    for name, module, function, title, caption in FIGURES:
        try:
            if not sources:
                raise Missing("no point has a result.")
            figure = getattr(importlib.import_module(module), function)(sources)
        except Missing as missing:
            figure = missing_figure(title.rstrip("."), str(missing))
        drawn.append((name, title, caption, save(figure, folder, name)))
    return drawn


def make(options):
    from campaign_file import InputError, read_campaign
    if len(options.campaigns) > MOST_CAMPAIGNS:
        raise InputError(f"{len(options.campaigns)} campaigns; expected {MOST_CAMPAIGNS} at most in one report")
    given = read_fits(options.fits)
    campaigns = [read_campaign(p, name) for p, name in zip(options.campaigns, labels_of(options.campaigns, options.label))]
    out = pathlib.Path(options.out)
    try:
        out.mkdir(parents=True, exist_ok=True)
        cache = tempfile.mkdtemp(prefix=".fonts-", dir=out)
    except OSError as error:
        raise InputError(f"{out}: {error.strerror}; expected a folder that can be written") from None
    try:
        os.environ["MPLCONFIGDIR"] = cache
        os.environ["MPLBACKEND"] = "Agg"
        from page import page
        from paper_numbers import analyse, fit_table, paper_rows
        from sources import sources_of
        analyses = [analyse(c) for c in campaigns]
        sources, note = sources_of(analyses)
        figures = draw(sources, out)
        tables = [(paper_rows(a), fit_table(a)) for a in analyses]
        whole = out / ".report.html.part"
        whole.write_text(page(analyses, figures, tables, given, [note] if note else []), encoding="utf-8")
        whole.replace(out / "report.html")
    finally:
        shutil.rmtree(cache, ignore_errors=True)
    for a, (rows, _) in zip(analyses, tables):
        print_table(a.campaign.label, rows)
    print(f"{out / 'report.html'}")


def print_table(label, rows):
    from drawing import with_error
    print(f"{label!a}: {'the paper':>55} {'ours':>18} {'truth':>12} {'z':>7}")
    for r in rows:
        show = lambda x, f: format(x, f) if x == x else "-"
        print(f"  {r.quantity:50s} {r.paper:>15} {with_error(r.ours, r.error):>18} {show(r.truth, '.7g'):>12}"
              f" {show(r.z, '.2f'):>7} {r.unit}")


def main(words):
    options = read_arguments(words)
    from campaign_file import InputError
    try:
        make(options)
    except InputError as error:
        print(f"report: {error}", file=sys.stderr)
        return 2
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
