#!/usr/bin/python3
"""Draws coverage and residuals of a board calibration.

  plot_board.py CORNERS.csv [PICTURE.png]     CORNERS.csv: of shakerd calibrate camera --corners"""
import csv
import pathlib
import re
import sys

import matplotlib
matplotlib.use("Agg")
import matplotlib.pyplot as plt
import numpy as np


def read(file):
    """Size of the pictures in px, and the rows."""
    lines = pathlib.Path(file).read_text().splitlines()
    size = re.fullmatch(r"# width_px = (\d+), height_px = (\d+)", lines[0])
    if not size:
        sys.exit(f"{file}:1: expected the size of the pictures; is it of shakerd calibrate camera --corners?")
    return (int(size[1]), int(size[2])), list(csv.DictReader(lines[1:]))


def draw(size, rows, file):
    number = lambda key, chosen: np.array([float(row[key]) for row in chosen])
    used = [row for row in rows if row["used"] == "1"]
    fig, (places, cloud) = plt.subplots(1, 2, figsize=(11, 4.2), width_ratios=(2.2, 1), layout="constrained")
    rms = np.sqrt(np.mean(np.concatenate([number("off_x_px", used), number("off_y_px", used)]) ** 2))
    longest = 0.06 * size[0]  # of an arrow of three standard deviations
    for picture in sorted({int(row["picture"]) for row in used}):
        chosen = [row for row in used if int(row["picture"]) == picture]
        x, y = number("x_px", chosen), number("y_px", chosen)
        dx, dy = number("off_x_px", chosen), number("off_y_px", chosen)
        colour = f"C{(picture - 1) % 10}"
        places.quiver(x, y, dx, dy, color=colour, angles="xy", scale_units="xy", scale=3 * rms / longest, width=2e-3)
        places.plot(x, y, ".", ms=2, color=colour)
        cloud.plot(1e3 * dx, 1e3 * dy, ".", ms=3, color=colour, label=f"picture {picture}")
    left_out = [row for row in rows if row["used"] != "1"]
    if left_out:
        places.plot(number("x_px", left_out), number("y_px", left_out), "kx", label="left out")
        places.legend()
    places.set(xlim=(-0.5, size[0] - 0.5), ylim=(size[1] - 0.5, -0.5), xlabel="x / px", ylabel="y / px",
               aspect="equal", title=f"{len(used)} corners; an arrow of {longest:.0f} px is {3e3 * rms:.1f} mpx")
    cloud.set(xlabel="residual in x / mpx", ylabel="residual in y / mpx", aspect="equal",
              title=f"rms {1e3 * rms:.1f} mpx")
    cloud.legend(fontsize=7)
    fig.savefig(file, dpi=110)


if __name__ == "__main__":
    if len(sys.argv) not in (2, 3):
        sys.exit(__doc__)
    source = pathlib.Path(sys.argv[1])
    draw(*read(source), sys.argv[2] if len(sys.argv) == 3 else source.with_suffix(".png"))
