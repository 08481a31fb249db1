"""Single recordings on one page: results, one averaged period of the walk, events, settings."""
import matplotlib.pyplot as plt
import numpy as np

from drawing import Missing, angle_name, colour_of, key, points, with_error
from page import esc, figure_part, grid, number, whole
from walker_law import G

MOST_DRAWN = 6  # measurements in the figures
RESULTS = (("v_D", 1e3, "v_D (mm/s)"), ("D", 1e3, "D (mm)"), ("gamma", 1 / G, "gamma (g)"), ("phi", 1, "phi (rad)"),
           ("rho", 1, "rho"), ("frequency", 1, "frequency (Hz)"), ("efficiency", 1, "efficiency"))


def drawn(recordings):
    """(measurement, colour) of those with a period, at most MOST_DRAWN spread over all."""
    found = [m for r in recordings for m in r.measurements if len(m.cycle["v"])]
    if not found:
        raise Missing("no recording has an averaged period.")
    rows = np.unique(np.linspace(0, len(found) - 1, min(MOST_DRAWN, len(found))).round().astype(int))
    return [(found[k], colour_of(j)) for j, k in enumerate(rows)]


def label_of(m):
    return f"{m.name}: γ = {m.results['gamma'] / G:.3g} g, φ = {angle_name(np.mod(m.results['phi'] + 0.1, 2 * np.pi) - 0.1)}"


def fig_x(recordings):
    """x(t) over one period."""
    chosen = drawn(recordings)
    shown, axes = plt.subplots()
    for m, colour in chosen:
        points(axes, m.cycle["phase"], 1e3 * m.cycle["x"], 1e3 * m.cycle["x_errors"], colour, ".", label=label_of(m))
    axes.set(xlabel="t / T", ylabel="x − x(0) (mm)", xlim=(0, 1))
    axes.legend()
    return shown


def fig_v(recordings):
    """v(t) / V of walker and base over one period, V = gamma / w; the measured stick intervals shaded."""
    chosen = drawn(recordings)
    shown, axes = plt.subplots()
    for m, colour in chosen:
        V = m.results["gamma"] / (2 * np.pi * m.results["frequency"])
        points(axes, m.cycle["phase"], m.cycle["v"] / V, m.cycle["v_errors"] / V, colour, ".")
        axes.plot(m.cycle["phase"], m.cycle["v_base"] / V, color=colour, lw=0.9)
        for start, end in zip(m.stick["from"], m.stick["to"]):
            for turn in (0, 1):  # an interval may continue in the next period
                axes.axvspan(start - turn, end - turn, color=colour, alpha=0.15, lw=0)
    axes.set(xlabel="t / T", ylabel="v / V,  V = γ/ω", xlim=(0, 1))
    key(axes, [("walker", {"marker": "."}), ("base", {"lw": 0.9})], loc="upper left")
    return shown


def result_table(recordings):
    rows = []
    for m in (m for r in recordings for m in r.measurements):
        s, asked = m.stick, m.asked
        sticks = ", ".join(f"{a:.3f} to {b:.3f} ± {e:.3f}" for a, b, e in zip(s["from"], s["to"], s["errors"]))
        rows.append((m.name, f"{asked['asked_gamma'] / G:.4g} g, {np.degrees(asked['asked_phi']):.4g} deg" if asked else "–",
                     *(with_error(scale * m.results[name], scale * m.results[f"{name}_errors"])
                       if np.isfinite(m.results[name]) else "–" for name, scale, _ in RESULTS),
                     number(1e3 * m.truth, 7), sticks or "none"))
    return grid(("measurement", "set-point", *(head for _, _, head in RESULTS), "true v_D (mm/s)", "stick intervals (T)"), rows,
                set(range(2, 3 + len(RESULTS))))


def recording_page(recordings, figures, notes):
    """figures: (name, title, caption, SVG); notes: on the figures."""
    results = sum(len(r.measurements) for r in recordings)
    parts = ["<p>Errors of the last digits are standard errors.</p>" + result_table(recordings) if results else
             "<p class=bad>No recording has results.</p>",
             figure_part(figures, notes + [f"{MOST_DRAWN} of the {results} measurements are drawn."] * (results > MOST_DRAWN))]
    for k, r in enumerate(recordings):
        parts += [f'<h2 id="recording{k}">{esc(r.label)}: {esc(r.title)}</h2><p class=weak>{esc(r.path)}, {esc(r.words)}</p>',
                  *(f"<p class=bad>{esc(note)}</p>" for note in r.notes), "<h3>Events</h3>",
                  grid(("time (s)", "state", "text"), [(f"{t:.3f}", *rest) for t, *rest in r.events], {0}),
                  *(f"<details><summary>{name}</summary><pre>{esc(text)}</pre></details>" for name, text in r.settings)]
    return whole(" / ".join(dict.fromkeys(r.title for r in recordings)),
                 [("figures", "Figures"), *((f"recording{k}", r.label) for k, r in enumerate(recordings))], parts)
