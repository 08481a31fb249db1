"""Style of the figures, text from files in them, and their files."""
import io
import re

import matplotlib
import matplotlib.pyplot as plt
import numpy as np

# Okabe and Ito: distinct for all kinds of colour vision.
COLOURS = ["#0072b2", "#d55e00", "#009e73", "#cc79a7", "#e69f00", "#56b4e9", "#7f7f7f", "#a6761d"]
MARKERS = ["o", "s", "D", "^", "v", "P"]
LINES = ["-", (0, (6, 1)), (0, (4, 1, 1, 1)), (0, (1, 1)), (0, (8, 2, 2, 2)), (0, (3, 3))]
REFUSED = (0, (2, 2))  # curves of a law that the data refuse
PAPER = "#888888"  # curves and numbers of the paper
KINDS = {"pdf": {"CreationDate": None}, "png": {}, "svg": {"Date": None}}  # files of a figure, with their metadata

matplotlib.rcParams.update({
    "figure.figsize": (6.4, 4.3), "figure.constrained_layout.use": True, "font.size": 9, "axes.grid": True,
    "grid.alpha": 0.25, "legend.fontsize": 7.5, "legend.framealpha": 0.85, "lines.linewidth": 1.2, "lines.markersize": 4,
    "errorbar.capsize": 1.5, "svg.fonttype": "path", "svg.hashsalt": "shakerd", "pdf.fonttype": 3, "savefig.dpi": 150})


def colour_of(index):
    return COLOURS[index % len(COLOURS)]


class Missing(Exception):
    """The points do not have what a figure shows; the message names what it needs."""


def plain(text, most=60):
    """Text from a file for matplotlib: one line, no mathematics, no characters that cannot be drawn."""
    text = re.sub(r"\s+", " ", "".join(c if c.isprintable() else " " for c in str(text))).strip()
    text = text if len(text) <= most else text[:most - 3] + "..."
    return " " + text.replace("$", r"\$") if text.startswith("_") else text.replace("$", r"\$")


def write(path, data):
    """A reader sees the old file or the complete new one; a link of that name is replaced, not followed."""
    part = path.with_name(f".{path.name}.part")
    part.unlink(missing_ok=True)
    with open(part, "xb") as file:
        file.write(data)
    part.replace(path)


def remove(folder, name):
    """Removes the files of an earlier figure."""
    for kind in KINDS:
        (folder / f"{name}.{kind}").unlink(missing_ok=True)


def save(figure, folder, name):
    """Writes NAME.svg, NAME.pdf and NAME.png; returns the text of the SVG."""
    figure.draw_without_rendering()
    figure.set_layout_engine("none")  # the layout is the same in all three files
    for kind, metadata in KINDS.items():
        content = io.BytesIO()
        figure.savefig(content, format=kind, metadata=metadata)
        write(folder / f"{name}.{kind}", content.getvalue())
    plt.close(figure)
    return content.getvalue().decode()


def points(axes, x, y, error, colour, marker, filled=True, label=None):
    """Measured points; open ones are larger and lie below."""
    error = np.where(np.isfinite(error) & (error > 0), error, 0)
    axes.errorbar(x, y, error, fmt=marker, color=colour, mfc=colour if filled else "white", mew=0.8, lw=0, elinewidth=0.8,
                  label=label, zorder=4 if filled else 3, ms=None if filled or marker == "." else 6.5)


def band(axes, x, middle, low, high, colour, line="-", label=None, width=1.2):
    axes.plot(x, middle, ls=line, color=colour, lw=width, label=label)
    axes.fill_between(x, np.minimum(low, high), np.maximum(low, high), color=colour, alpha=0.2, lw=0)


def key(axes, entries, **place):
    """Legend from (label, keyword arguments of a line) pairs; several may be on one axes."""
    look_of = lambda look: {"color": "0.3", "lw": 0, **look, **({} if look.get("lw") else {"ls": ""})}
    handles = [plt.Line2D([], [], **look_of(look)) for _, look in entries]
    legend = axes.legend(handles, [label for label, _ in entries], **place)
    axes.add_artist(legend)
    return legend


def with_error(value, error):
    """0.112979(2): the error in units of the last digit; two digits of it where the first is 1."""
    if not (np.isfinite(value) and np.isfinite(error) and error > 0):
        return f"{value:.6g}"
    digits = -int(np.floor(np.log10(error)))
    if error * 10**digits < 1.95:
        digits += 1
    if digits <= 0:
        return f"{value:.0f}({error:.0f})"
    if digits > 12:
        return f"{value:.6g}"
    return f"{value:.{digits}f}({round(error * 10**digits)})"


def angle_name(phi):
    """Name of a phase: multiples of pi/12 as fractions, others in degrees."""
    twelfths = phi / (np.pi / 12)
    if abs(twelfths - round(twelfths)) > 0.02:
        return f"{np.degrees(phi):.4g}°"
    n, d = int(round(twelfths)), 12
    while d > 1 and any(n % k == 0 and d % k == 0 for k in (2, 3)):
        k = next(k for k in (2, 3) if n % k == 0 and d % k == 0)
        n, d = n // k, d // k
    return "0" if n == 0 else ("" if n == 1 else str(n)) + "π" + ("" if d == 1 else f"/{d}")
