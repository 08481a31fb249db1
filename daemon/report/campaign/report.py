#!/usr/bin/python3
"""Draws campaigns: the figures of the paper, fits, and the paper's numbers beside them, as one HTML page. Or recordings.

  report.py FOLDER_OR_FILE... -o OUT [--fits FILE.json] [--label NAME]...

FOLDER_OR_FILE  folder of a campaign, or its campaign.nxs; several are compared. Or recordings, without campaigns
-o OUT          folder, made when it is missing: report.html and each figure as SVG, PDF and PNG
--fits FILE     output of "shakerd mu --json"; for several campaigns a list of theirs: daemon/report/campaign/README.md
--label NAME    name in the legends, in the order of the files; default: name of the folder or the recording

Needs python3-h5py and python3-matplotlib. Exit status: 0 done; 1 output not written; 2 input refused, nothing was written.
"""
import argparse
import os
import pathlib
import shutil
import sys
import tempfile

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")  # the arrays are small
sys.dont_write_bytecode = True  # the folder of the scripts may be read-only
sys.path.insert(0, os.path.dirname(os.path.abspath(__file__)))

MOST_FILES = 6

FIGURES = (  # name, module, function, title, caption
    ("fig2a", "figures_cycles", "fig_2a", "Fig. 2(a).", "Walk in one period, averaged. Lines: the law in the legend."),
    ("fig2b", "figures_drift", "fig_2b", "Fig. 2(b).", "Drift velocity against gamma. Bands: two errors of mu."),
    ("fig2c", "figures_cycles", "fig_2c", "Fig. 2(c).", "Velocity in one period at phi = 0; shaded: the measured stick interval."),
    ("fig2d", "figures_cycles", "fig_2d", "Fig. 2(d).", "Velocity in one period at phi = pi/2; shaded: the measured stick interval."),
    ("fig3a", "figures_drift", "fig_3a", "Fig. 3(a).", "Drift velocity against phi."),
    ("fig3b", "figures_drift", "fig_3b", "Fig. 3(b).", "Null phase less pi/2 against gamma. Bands: two errors of mu."),
    ("fig4", "figures_drift", "fig_4", "Fig. 4.", "Efficiency against gamma."),
    ("residuals", "figures_drift", "fig_residuals", "Residuals.", "Measured v_D less Coulomb's law with mu_ac at the measured drive."),
    ("friction", "figures_friction", "fig_friction", "Friction.", "Friction between the kinks against the velocity of slip, from x(t)"
     " alone. Lines: the law that describes v_D."))
RECORDING_FIGURES = (
    ("period_x", "recordings", "fig_x", "Walk.", "Walk in one period, averaged, as in Fig. 2(a)."),
    ("period_v", "recordings", "fig_v", "Velocity.", "Velocity in one period, as in Fig. 2(c). Points: walker; lines: base;"
     " shaded: the measured stick intervals."))


def read_arguments(words):
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter, usage=argparse.SUPPRESS)
    parser.add_argument("files", nargs="+", metavar="FOLDER_OR_FILE")
    parser.add_argument("-o", "--out", required=True)
    parser.add_argument("--fits")
    parser.add_argument("--label", action="append", default=[])
    return parser.parse_args(words)


def labels_of(paths, given):
    """Unique names: those of the options, then those of the folders and recordings."""
    from campaign_file import InputError
    if len(given) > len(paths):
        raise InputError(f"--label: {len(given)} names for {len(paths)} files; expected one for each at most")
    names = []
    for k, path in enumerate(paths):
        place = pathlib.Path(path).resolve()
        own = place.parent.name if place.name == "campaign.nxs" else place.stem if place.is_file() else place.name
        name = given[k] if k < len(given) else own or "campaign"
        names.append(name if name not in names else f"{name} ({k + 1})")
    return names


def draw(figures, data, folder):
    """Figures of sources or recordings into the folder: [(name, title, caption, SVG)] and sentences on those not drawn."""
    import importlib

    from drawing import Missing, remove, save
    drawn, missing = [], []
    for name, module, function, title, caption in figures:
        try:
            drawn.append((name, title, caption, save(getattr(importlib.import_module(module), function)(data), folder, name)))
        except Missing as reason:
            remove(folder, name)
            missing.append(f"{title} Not drawn: {reason}")
    return drawn, missing


def make(options):
    import recording_file
    from campaign_file import InputError, read_campaign
    from fits import read_fits
    if len(options.files) > MOST_FILES:
        raise InputError(f"{len(options.files)} files; expected {MOST_FILES} at most in one report")
    named = list(zip(options.files, labels_of(options.files, options.label)))
    single = [recording_file.kind_of(path) in recording_file.KINDS for path in options.files]
    if any(single) and (options.fits or not all(single)):
        raise InputError(f"{options.files[single.index(True)]}: a single recording; expected recordings alone and no fits,"
                         " or campaigns alone")
    given = read_fits(options.fits, len(options.files))
    data = [recording_file.read_recording(*n) if any(single) else read_campaign(*n) for n in named]
    out = pathlib.Path(options.out)
    try:
        out.mkdir(parents=True, exist_ok=True)
        cache = tempfile.mkdtemp(prefix=".fonts-", dir=out)
    except OSError as error:
        raise InputError(f"{out}: {error.strerror}; expected a folder that can be written") from None
    try:
        os.environ["MPLCONFIGDIR"] = cache
        os.environ["MPLBACKEND"] = "Agg"
        from drawing import write
        text = recording_report(data, out) if any(single) else campaign_report(data, given, out)
        write(out / "report.html", text.encode("utf-8", "replace"))
    finally:
        shutil.rmtree(cache, ignore_errors=True)
    print(out / "report.html")


def recording_report(recordings, out):
    from recordings import recording_page
    return recording_page(recordings, *draw(RECORDING_FIGURES, recordings, out))


def campaign_report(campaigns, given, out):
    from page import page
    from paper_numbers import analyse, paper_rows
    from sources import sources_of
    analyses = [analyse(c, fits) for c, fits in zip(campaigns, given)]
    sources, note = sources_of(analyses)
    tables = [paper_rows(a) for a in analyses]
    for a, rows in zip(analyses, tables):
        print_table(a.campaign.label, rows)
    figures, missing = draw(FIGURES if sources else (), sources, out)
    return page(analyses, figures, missing + ([note] if note else []), tables)


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
    except OSError as error:
        print(f"report: the page could not be written: {error}", file=sys.stderr)
        return 1
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
