#!/usr/bin/python3
"""Draws the response of an accelerometer: the lines with their errors, and the fitted model.

  plot_response.py RESPONSE.toml [PICTURE.png]     RESPONSE.toml: of shakerd calibrate response"""
import pathlib
import sys
import tomllib

import matplotlib
matplotlib.use("Agg")
import matplotlib.pyplot as plt
import numpy as np


def denominator(ix, order, damping):
    return 1 + ix if order == 1 else 1 + 2 * damping * ix + ix**2


def response(told, hz):
    """Output over input; the delay of the low-pass at low frequencies is left out."""
    h = np.ones(len(hz), complex)
    if told.get("high_pass_hz", 0) > 0:
        h /= denominator(-1j * told["high_pass_hz"] / hz, told["high_pass_order"], told.get("high_pass_damping", 1))
    if "low_pass_hz" in told:
        order, damping, x = told["low_pass_order"], told.get("low_pass_damping", 0.5**0.5), hz / told["low_pass_hz"]
        h *= np.exp(1j * x * (1 if order == 1 else 2 * damping)) / denominator(1j * x, order, damping)
    return h


def draw(told, title, file):
    hz, gain, gain_error, phase, phase_error = np.reshape(told["residuals"], (-1, 5)).T
    shown = gain_error < 0.1
    at, curve = response(told, hz), np.geomspace(0.8 * hz[shown].min(), 1.25 * hz[shown].max(), 400)
    model = response(told, curve)
    fig, panels = plt.subplots(2, 1, figsize=(7, 6), sharex=True, layout="constrained")
    for panel, scale, line, error, smooth in (
            (panels[0], 100, np.log(np.abs(at)) + gain, gain_error, np.log(np.abs(model))),
            (panels[1], 1e3, np.angle(at) + phase, phase_error, np.angle(model))):
        panel.plot(curve, scale * smooth, "C1")
        panel.errorbar(hz[shown], scale * line[shown], scale * error[shown], fmt="C0.", capsize=2)
        panel.axhline(0, color="0.7", lw=0.8)
    panels[0].set(ylabel="amplitude / %", title=title)
    panels[1].set(xscale="log", xlabel="frequency / Hz", ylabel="phase without delay / mrad")
    fig.savefig(file, dpi=110)


if __name__ == "__main__":
    if len(sys.argv) not in (2, 3):
        sys.exit(__doc__)
    source = pathlib.Path(sys.argv[1])
    try:
        told = tomllib.loads(source.read_text())
        picture = sys.argv[2] if len(sys.argv) == 3 else source.with_suffix(".png")
        draw(told, f"{told['sensor']}, {told['date'][:10]}", picture)
    except (OSError, tomllib.TOMLDecodeError, KeyError) as error:
        sys.exit(f"{source}: is not of shakerd calibrate response: {error}")
