"""The page: one HTML file without external resources. Every text from a file passes esc()."""
import base64
import html
import json

import numpy as np

from campaign_file import number as number_of, unmeasured
from drawing import with_error
from walker_law import G

STYLE = """
:root{color-scheme:light dark;--fg:#1b1f24;--bg:#fff;--soft:#f3f5f7;--line:#d5dae0;--weak:#5b6570;--bad:#a40e26}
@media(prefers-color-scheme:dark){:root{--fg:#e2e6ea;--bg:#14181d;--soft:#1e242b;--line:#3a434d;--weak:#9aa5b1;--bad:#ff8f9b}
 .drawn img{filter:invert(.92) hue-rotate(180deg)}}
body{font:15px/1.5 system-ui,sans-serif;color:var(--fg);background:var(--bg);max-width:76rem;margin:0 auto;padding:1rem 1.2rem}
h1{font-size:1.5rem;margin:.3rem 0}h2{font-size:1.2rem;margin:2rem 0 .5rem;border-bottom:1px solid var(--line)}
h3{font-size:1rem;margin:1.2rem 0 .3rem}p{margin:.4rem 0}.weak{color:var(--weak)}.bad{color:var(--bad)}
.figures{display:grid;grid-template-columns:repeat(auto-fit,minmax(min(100%,30rem),1fr));gap:1rem}
figure{margin:0;border:1px solid var(--line);border-radius:4px;padding:.5rem}figure img{width:100%;height:auto;display:block}
figcaption{font-size:.85rem;color:var(--weak)}.wide{overflow-x:auto}
table{border-collapse:collapse;font-size:.87rem;font-variant-numeric:tabular-nums;margin:.3rem 0}
th,td{border:1px solid var(--line);padding:.15rem .5rem;text-align:left;vertical-align:top;overflow-wrap:break-word;max-width:38rem}
th{background:var(--soft)}td.n{text-align:right;white-space:nowrap}td.s{white-space:nowrap}td:last-child{min-width:9rem}
pre{background:var(--soft);padding:.6rem;overflow:auto;max-height:24rem;font-size:.82rem}nav a{margin-right:.9rem}
@media print{nav{display:none}figure,tr{break-inside:avoid}}
"""
MOST_ROWS = 400
CURVES = {"time": " with the mu that is left in the end", "place": " with the mu at the mean place"}  # of laws that change


def esc(text):
    return html.escape(str(text), quote=True)


def number(value, digits=5):
    return "–" if not np.isfinite(value) else f"{value:.{digits}g}"


def grid(head, rows, numbers=()):
    """A table. Cells are escaped; the columns `numbers` are aligned to the right."""
    kind = lambda k, text: ' class="n"' if k in numbers else ' class="s"' if len(str(text)) < 24 else ""
    cell = lambda k, text: f"<td{kind(k, text)}>{esc(text)}</td>"
    body = "".join("<tr>" + "".join(cell(k, text) for k, text in enumerate(row)) + "</tr>\n" for row in rows[:MOST_ROWS])
    more = f"<p class=weak>{len(rows) - MOST_ROWS} more rows.</p>" if len(rows) > MOST_ROWS else ""
    return ('<div class="wide"><table><thead><tr>' + "".join(f"<th>{esc(h)}</th>" for h in head)
            + f"</tr></thead><tbody>\n{body}</tbody></table></div>{more}")


def data_uri(data, kind):
    return f"data:{kind};base64,{base64.b64encode(data).decode()}"


def figure(name, title, caption, svg):
    """An image cannot run scripts, and its identifiers do not meet those of other figures."""
    return (f'<figure class="drawn" id="{esc(name)}"><img alt="{esc(title)}" src="{data_uri(svg.encode(), "image/svg+xml")}">'
            f"<figcaption><b>{esc(title)}</b> {esc(caption)}</figcaption></figure>\n")


def figure_part(figures, notes):
    return ('<h2 id="figures">Figures</h2><div class="figures">' + "".join(figure(*f) for f in figures) + "</div>"
            + "".join(f"<p class=weak>{esc(note)}</p>" for note in notes))


def paper_table(rows):
    cells = [(r.quantity, r.paper, with_error(r.ours, r.error), r.unit, number(r.truth, 7), number(r.z, 3),
              "–" if not np.isfinite(r.to_paper) else f"{100 * r.to_paper:+.1f} %", r.note) for r in rows]
    return grid(("quantity", "the paper", "ours (standard error of the last digits)", "unit", "truth",
                 "z = (ours − truth) / error", "ours to the paper", "note"), cells, {2, 4, 5, 6})


def compared(labels, tables):
    """The quantities of several campaigns side by side; z: difference from the first campaign over the errors of both."""
    columns = [{r.quantity: r for r in rows} for rows in tables]
    quantities = dict.fromkeys(q for rows in columns for q in rows)
    cells = []
    for q in quantities:
        first, line = columns[0].get(q), [q, next(c[q].paper for c in columns if q in c)]
        for c in columns:
            r = c.get(q)
            text = with_error(r.ours, r.error) + " " + r.unit if r else "–"
            if r and first and r is not first and r.comparable and r.error > 0 and first.error > 0:
                text += f" (z {(r.ours - first.ours) / np.hypot(r.error, first.error):+.1f})"
            line.append(text)
        cells.append(line)
    return grid(("quantity", "the paper", *labels), cells, set(range(2, 2 + len(labels))))


def fit_name(fit):
    place = f" at {fit.gamma / G:.4g} g" if np.isfinite(fit.gamma) else ""
    place += f" at {np.degrees(fit.phi):.1f} deg" if np.isfinite(fit.phi) else ""
    return fit.name + place + (f" ({fit.series})" if fit.series else "")


def fit_part(fits):
    if not fits.all:
        return ("<p>None. Fits come from <code>shakerd mu</code>, which needs a measured point; <code>report.py</code> takes them"
                " by <code>--fits</code>.</p>")
    value = lambda f: with_error(f.value, f.error) if np.isfinite(f.value) else "–"
    return grid(("fit", "value (error of the points)", "unit", "truth", "chi2 / freedom", "points", "note"),
                [(fit_name(f), value(f), f.unit, number(f.truth, 7), number(f.chi2, 3), number(f.points), f.note)
                 for f in fits.all], {1, 3, 4, 5})


def law_part(fits):
    laws = fits.verdict.get("laws", [])
    if not laws:
        return "<p>Coulomb's law was not refused; <code>shakerd law</code> compares all laws.</p>"
    parameters = lambda law: ", ".join(
        f"{p.get('name')} {with_error(number_of(p.get('value')), number_of(p.get('error')))}"
        f"{'' if p.get('unit') == '1' else ' ' + str(p.get('unit'))}" for p in law.get("parameters", []))
    chi2 = lambda law, of: number(number_of(law.get(of)), 4)
    return f"<p class=bad>{esc(fits.verdict.get('sentence', ''))}.</p>" + grid(
        ("law", "mu (error of the points)", "parameters", "chi2 of v_D", "freedom", "chi2 of harmonics 9 to 16", "score"),
        [(law.get("words", ""), with_error(number_of(law.get("mu")), number_of(law.get("mu_error"))), parameters(law),
          chi2(law, "chi2"), law.get("freedom", ""), chi2(law, "chi2_base"), chi2(law, "score"))
         if not law.get("reason") else (law.get("words", ""), "–", str(law["reason"]), "", "", "", "") for law in laws],
        {3, 4, 5, 6})


def budget_part(fits):
    parts = []
    for name, lines in fits.budgets.items():
        if lines:
            parts.append(f"<p><b>{esc(name)}</b> = {esc(with_error(fits.one(name).value, fits.total_error(name)))}</p>" + grid(
                ("source", "relative error (%)", "input"),
                [(line["source"], number(100 * line["share"], 3), line.get("input", "")) for line in lines], {1}))
    return "".join(parts) or "<p>None.</p>"


def journal_rows(campaign):
    rows = []
    for e in campaign.journal:
        what, point = e.get("what", ""), e.get("point", "")
        change = e.get("change") or e.get("outcome") or e.get("how") or ""
        where = f"point {point}" + (f", pass {e['pass']}" if "pass" in e else "") if point != "" else ""
        rows.append((e.get("time", ""), what, where, change, e.get("reason", "")))
    return rows


def summary(analysis):
    c, p = analysis.campaign, analysis.campaign.points
    outcomes = {}
    for word in p["outcome"]:
        outcomes[word] = outcomes.get(word, 0) + 1
    counts = ", ".join(f"{n} {word}" for word, n in outcomes.items()) or "no points"
    time = [t for t in p.get("time", []) if t]
    parts = [f"{len(p['point'])} points: {counts}. "]
    if time:
        parts.append(f"{min(time)} to {max(time)}. ")
    parts.append("; ".join(s.words + f" ({len(s.rows)} points)" for s in analysis.settings[:6]) + ". " if analysis.settings else
                 "No point has a result, so there are no fits and no figures. ")
    if c.scene:
        w = c.scene["walker"]
        parts.append(f"Simulated bench: mu_k {w.get('mu_k', '?')}, mu_s {w.get('mu_s', '?')},"
                     f" tilt {c.scene.get('tilt_deg', '?')} deg.")
    elif np.isfinite(p["true_v_D"]).any():
        parts.append("Simulated bench; its scene is not known.")
    return "".join(parts)


def campaign_part(analysis, number_of):
    """Plan, events, points without a result and picture of a campaign."""
    c = analysis.campaign
    missing, events, waiting = unmeasured(c), journal_rows(c), int(np.sum(c.points["outcome"] == "not begun"))
    parts = [f'<h2 id="campaign{number_of}">{esc(c.label)}: {esc(c.title)}</h2><p>{esc(summary(analysis))}</p>',
             f"<p class=weak>{esc(c.path)}, written by {esc(c.program or 'an unknown program')}</p>"]
    parts += [f"<p class=bad>{esc(note)}</p>" for note in dict.fromkeys(c.notes)]
    fits = analysis.fits
    if len(fits.rows):
        parts.append(f"<p>Coulomb's law with mu_ac at the measured drives, with the push of the walker on the base: chi2"
                     f" {number(fits.one('mu_ac').chi2, 3)}, {int(np.sum(np.abs(fits.z) > 3))} of {len(fits.z)} points beyond 3"
                     " errors.</p>")
    if fits.verdict:
        of = "Coulomb's law with mu_ac, which the data refuse" if analysis.law.refused else "this law" + CURVES.get(
            str(fits.verdict.get("chosen")), "")
        parts.append(f"<p class=bad>{esc(fits.verdict.get('sentence', ''))}. The curves in the figures are those of {of}.</p>")
    parts.append("<h3>Points without a result</h3>" + (grid(("point", "series", "set-point", "outcome", "reason"), missing)
                                                       if missing else "" if waiting else "<p>None.</p>"))
    if waiting:
        parts.append(f"<p>{waiting} points were not begun; <code>shakerd campaign FOLDER --continue</code> measures them.</p>")
    parts.append("<h3>Events</h3>" + (grid(("time", "entry", "where", "what", "reason"), events) if events else
                                      "<p>None: no journal, or nothing but complete passes.</p>"))
    if c.picture:
        kind = "image/png" if c.picture.suffix == ".png" else "image/jpeg"
        parts.append(f'<h3>Bench</h3><figure><img alt="bench" src="{data_uri(c.picture.read_bytes(), kind)}"></figure>')
    parts.append(f"<h3>Settings</h3><details><summary>plan</summary><pre>{esc(c.plan)}</pre></details>" + point_table(c))
    if c.scene:
        parts.append(f"<details><summary>scene</summary><pre>{esc(json.dumps(c.scene, indent=1, default=str))}</pre></details>")
    return "\n".join(parts)


def point_table(c):
    p, rows = c.points, []
    for k in np.flatnonzero(c.measured):
        rows.append((f"{p['point'][k]:.0f}", p["series"][k], f"{p['frequency'][k]:.6g}", f"{p['gamma'][k] / G:.5f}",
                     f"{p['phi'][k]:.5f}", with_error(1e3 * p["v_D"][k], 1e3 * p["v_D_errors"][k]),
                     with_error(p["efficiency"][k], p["efficiency_errors"][k]), number(1e3 * p["true_v_D"][k], 8),
                     number(p["periods"][k])))
    head = ("point", "series", "frequency (Hz)", "gamma (g)", "phi (rad)", "v_D (mm/s)", "efficiency", "true v_D (mm/s)",
            "periods")
    return "<details><summary>measured points</summary>" + grid(head, rows, {0, 2, 3, 4, 5, 6, 7, 8}) + "</details>"


def whole(title, links, parts):
    """A complete page; links: (identifier of a heading, name)."""
    return "\n".join([
        f'<!doctype html><html lang="en"><head><meta charset="utf-8"><title>{esc(title)}</title>',
        '<meta http-equiv="Content-Security-Policy" content="default-src \'none\'; img-src data:; style-src \'unsafe-inline\'">',
        '<meta name="viewport" content="width=device-width, initial-scale=1">', f"<style>{STYLE}</style></head><body>",
        f"<h1>{esc(title)}</h1>", "<nav>" + "".join(f'<a href="#{esc(at)}">{esc(name)}</a>' for at, name in links) + "</nav>",
        *parts, "</body></html>\n"])


def page(analyses, figures, notes, tables):
    """figures: (name, title, caption, SVG); notes: on the figures; tables: for each campaign the rows of the paper."""
    title = " / ".join(dict.fromkeys(a.campaign.title for a in analyses)) or "campaign"
    parts = [f"<p><b>{esc(a.campaign.label)}</b>: {esc(summary(a))}</p>" for a in analyses]
    parts.append(figure_part(figures, notes))
    parts.append('<h2 id="paper">The paper beside us</h2><p class=weak>Maza-Cuello and Maza, Efficient transport controlled by'
                 " biharmonic frictional driving. Truth: of a simulated bench. Errors of mu_ac, mu_k and mu_ns have the whole"
                 " budget; z counts no other errors than those shown.</p>")
    if len(analyses) > 1:
        parts.append("<h3>Side by side</h3><p class=weak>z: difference from the first campaign over the errors of both.</p>"
                     + compared([a.campaign.label for a in analyses], tables))
    each = lambda content: [f"<h3>{esc(a.campaign.label)}</h3>" + content(a, rows) for a, rows in zip(analyses, tables)]
    parts += each(lambda a, rows: paper_table(rows) if rows else "<p>No points with a result.</p>")
    parts += ['<h2 id="fits">Fits</h2>', *each(lambda a, rows: fit_part(a.fits))]
    parts += ['<h2 id="laws">Laws of friction</h2>', *each(lambda a, rows: law_part(a.fits))]
    parts += ['<h2 id="budgets">Budgets</h2>', *each(lambda a, rows: budget_part(a.fits))]
    parts += [campaign_part(a, k) for k, a in enumerate(analyses)]
    links = [("figures", "Figures"), ("paper", "The paper beside us"), ("fits", "Fits"), ("laws", "Laws of friction"), ("budgets", "Budgets")]
    return whole(title, links + [(f"campaign{k}", a.campaign.label) for k, a in enumerate(analyses)], parts)
