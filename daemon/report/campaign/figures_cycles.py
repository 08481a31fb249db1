"""Figs. 2(a), 2(c), 2(d): one period of the walker. Points: measured; lines: the law of the source on the drive as asked
for; black: velocity of the base."""
import matplotlib.pyplot as plt
import numpy as np

from drawing import Missing, colour_of, key, plain, points
from settings import near_phase
from walker_law import G

GAMMAS = (0.5, 1.0, 2.0)   # g, as in the paper where they were measured
FINE = np.linspace(0, 1, 601)


def rows_at(source, phi, most=4):
    """Points at phi with a cycle: at 0.5, 1 and 2 g, else at up to four gammas spread over the range."""
    p = source.campaign.points
    rows = source.setting.rows[near_phase(p["asked_phi"][source.setting.rows], phi)]
    rows = rows[np.isfinite(source.campaign.cycle["v"][rows]).any(1)]
    g = p["asked_gamma"][rows] / G
    _, first = np.unique(np.round(g, 4), return_index=True)
    rows, g = rows[first], g[first]
    wanted = [rows[np.abs(g - w) < 0.01][0] for w in GAMMAS if np.any(np.abs(g - w) < 0.01)]
    if len(wanted) >= 2:
        return np.array(wanted)
    return rows[np.unique(np.linspace(0, len(rows) - 1, min(most, len(rows))).round().astype(int))] if len(rows) else rows


def with_line(source, row, sources):
    """Whether the law is drawn there: for a source with curves, and at a gamma that no such source has at this phase."""
    asked = lambda s, k: (np.round(s.campaign.points["asked_gamma"][k] / G, 3), s.setting.words)
    phi = source.campaign.points["asked_phi"][row]
    return source.curves or all(asked(source, row) != asked(s, k) for s in sources if s.curves for k in rows_at(s, phi))


def law_cycle(source, row):
    """v(t) and x(t) - x(0) of the law at the phases FINE."""
    drives = source.campaign.asked_drives([row])
    v = source.law.settle(drives, phases=len(FINE) - 1).v[0]
    v = np.append(v, v[0])
    step = (v[1:] + v[:-1]) / 2 * (FINE[1] - FINE[0]) / drives.frequency[0]
    return v, np.concatenate([[0], np.cumsum(step)])


def fig_2a(sources):
    """x(t) over one period at phi = 0 and pi/2."""
    figure, axes = plt.subplots()
    marks, found = {0.0: "s", np.pi / 2: "D"}, {}
    for s in sources:
        for phi, mark in marks.items():
            for row in rows_at(s, phi):
                gamma = round(s.campaign.points["asked_gamma"][row] / G, 3)
                colour = colour_of(found.setdefault(gamma, len(found)))
                x, e = (1e3 * s.campaign.cycle[k][row] for k in ("x", "x_errors"))
                every = slice(sources.index(s) % 4, None, 4)
                points(axes, s.campaign.cycle["phase"][every], x[every], e[every], colour, mark, filled=s is sources[0])
                if with_line(s, row, sources):
                    axes.plot(FINE, 1e3 * law_cycle(s, row)[1], color=colour, ls=s.line, lw=0.9)
    if not found:
        plt.close(figure)
        raise Missing("it needs points at phi = 0 or 90 deg.")
    axes.set(xlabel="t / T", ylabel="x − x(0) (mm)", xlim=(0, 1))
    key(axes, [(f"γ = {g:g} g", {"color": colour_of(k), "lw": 2}) for g, k in sorted(found.items())], loc="upper left")
    key(axes, [("φ = 0", {"marker": "s"}), ("φ = π/2", {"marker": "D"})]
        + law_entries(sources) + source_entries(sources), loc="center left", bbox_to_anchor=(0, 0.6))
    return figure


def law_entries(sources):
    first = {}
    for s in sources:
        first.setdefault(plain(s.law.words), {"lw": 0.9, "ls": s.line})
    return list(first.items())


def source_entries(sources):
    first = sources[0]
    sources = [s for s in sources if len(rows_at(s, 0)) or len(rows_at(s, np.pi / 2))]
    if len(sources) < 2:
        return []
    return [(s.label, {"marker": "o", "mfc": "0.3" if s is first else "white", "lw": 0.9 if s.curves else 0, "ls": s.line})
            for s in sources]


def fig_2c(sources):
    return velocities(sources, 0.0, "0")


def fig_2d(sources):
    return velocities(sources, np.pi / 2, "π/2")


def velocities(sources, phi, name):
    """v(t) / V at one phase, V = gamma / w, with a magnified stick interval."""
    figure, axes = plt.subplots()
    colours, drawn = {}, []
    for s in sources:
        for row in rows_at(s, phi):
            gamma = round(s.campaign.points["asked_gamma"][row] / G, 3)
            drawn.append((s, row, gamma, colour_of(colours.setdefault(gamma, len(colours)))))
    if not drawn:
        plt.close(figure)
        raise Missing(f"it needs points at phi = {np.degrees(phi):g} deg.")
    shown = stick_to_show(drawn, largest=phi != 0)
    views = [axes]
    if shown:
        views.append(axes.inset_axes([0.36, 0.68, 0.3, 0.3] if phi == 0 else [0.36, 0.62, 0.3, 0.36]))
    for view in views:
        for s, row, _, colour in drawn:
            draw_velocity(view, s, row, colour, sources, every=1 if view is not axes else 2)
        s, row, _, _ = drawn[0]
        c = s.campaign.cycle
        view.plot(c["phase"], c["v_base"][row] / scale(s, row), color="black", lw=1.1, zorder=2)
    if shown:
        zoom(axes, views[1], shown, phi)
    axes.set(xlabel="t / T", ylabel="v / V,  V = γ/ω", xlim=(0, 1))
    axes.set_title(f"φ = {name}", fontsize=9)
    entries = [(f"γ = {g:g} g", {"color": colour_of(k), "marker": "o"}) for g, k in sorted(colours.items())]
    key(axes, entries + [("base", {"color": "black", "lw": 1.1})] + law_entries(sources),
        loc="upper left" if phi == 0 else "upper right")
    if source_entries(sources):
        key(axes, source_entries(sources), loc="lower center")
    return figure


def scale(source, row):
    p = source.campaign.points
    return p["gamma"][row] / (2 * np.pi * p["frequency"][row])


def draw_velocity(axes, source, row, colour, sources, every):
    c, V = source.campaign.cycle, scale(source, row)
    pick = slice(None, None, every)
    points(axes, c["phase"][pick], c["v"][row][pick] / V, c["v_errors"][row][pick] / V, colour, ".", source is sources[0])
    if with_line(source, row, sources):
        axes.plot(FINE, law_cycle(source, row)[0] / V, color=colour, ls=source.line, lw=0.9)


def stick_to_show(drawn, largest):
    """(from, to, colour, level) of the longest stick interval at the smallest or the largest gamma that has one."""
    for s, row, _, colour in sorted(drawn, key=lambda d: -d[2] if largest else d[2]):
        t = s.campaign.stick
        mine = np.flatnonzero((t["point"] == s.campaign.points["point"][row]) & np.isfinite(t["to"] - t["from"]))
        if len(mine):
            k = mine[np.argmax(t["to"][mine] - t["from"][mine])]
            start, end = t["from"][k], t["to"][k]
            if end <= 1.05:
                phase = s.campaign.cycle["phase"]
                inside = (phase > start - 0.04) & (phase < end + 0.04)
                level = np.concatenate([d[0].campaign.cycle["v"][d[1]][inside] / scale(d[0], d[1])
                                        for d in drawn if d[1] == row and d[0] is s])
                level = level[np.isfinite(level)]
                if len(level):
                    return start, end, colour, (level.min(), level.max())
    return None


def zoom(axes, inset, shown, phi):
    start, end, colour, (low, high) = shown
    inset.axvspan(start, end, color=colour, alpha=0.15, lw=0)
    room = 0.35 * (high - low) + 0.01
    inset.set(xlim=(start - 0.06, end + 0.06), ylim=(low - room, high + room))
    inset.tick_params(labelsize=6)
    inset.grid(alpha=0.2)
    axes.indicate_inset_zoom(inset, edgecolor="0.4", lw=0.6)
    inset.text(0.03, 0.97, f"stick {start:.3f} to {end:.3f} T", fontsize=6.5, va="top", transform=inset.transAxes)
    bottom, top = axes.get_ylim()
    axes.set_ylim(bottom, top + (top - bottom) * (0.45 if phi == 0 else 0.6))  # room for the inset above the curves
