"""The page: one HTML file without external resources. Every text from a file passes esc()."""
import base64
import html
import json

import numpy as np

from campaign_file import unmeasured
from coulomb_law import G
from drawing import with_error

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


def fit_rows(fits):
    def get(fit, key):
        return float(fit[key]) if isinstance(fit.get(key), (int, float)) else np.nan

    def name(fit):
        gamma, phi = get(fit, "gamma_mps2") / 9.8, get(fit, "phi_rad")
        place = f" at {gamma:.4g} g" if np.isfinite(gamma) else ""
        place += f" at {np.degrees(phi):.1f} deg" if np.isfinite(phi) else ""
        return f"{fit.get('name', '')}{place}" + (f" ({fit['series']})" if fit.get("series") else "")

    def value(fit):
        return with_error(get(fit, "value"), get(fit, "error")) if np.isfinite(get(fit, "value")) else "–"

    return grid(("fit", "value (standard error of the last digits)", "unit", "chi2", "points", "note"),
                [(name(f), value(f), f.get("unit", ""),
                  number(get(f, "chi2"), 3), number(get(f, "points")), f.get("note", "")) for f in fits], {1, 3, 4})


def budget_part(budgets):
    if not budgets:
        return ("<p class=weak>No budgets: they come from <code>shakerd mu</code>. The error of mu_ac on this"
                " page has the scatter and the errors of gamma and phi; it does not have the scales of the sensors and the"
                " model.</p>")
    parts = []
    for name, lines in budgets.items():
        ordered = sorted(lines, key=lambda line: -abs(line["share"]))
        parts.append(f"<h3>{esc(name)}</h3>" + grid(("source", "share of the error", ""), [
            (line["source"], number(line["share"], 3), line.get("note", "")) for line in ordered], {1}))
    return "".join(parts)


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
    missing, events = unmeasured(c), journal_rows(c)
    parts = [f'<h2 id="campaign{number_of}">{esc(c.label)}: {esc(c.title)}</h2><p>{esc(summary(analysis))}</p>',
             f"<p class=weak>{esc(c.path)}, written by {esc(c.program or 'an unknown program')}</p>"]
    parts += [f"<p class=bad>{esc(note)}</p>" for note in dict.fromkeys(c.notes)]
    law = analysis.law
    if law.known:
        parts.append(f"<p>Exact law at the measured drives, with the push of the walker on the base: chi2 {number(law.chi2, 3)},"
                     f" {int(np.sum(np.abs(law.z) > 3))} of {len(law.z)} points beyond 3 errors.</p>")
    elif law.note:
        parts.append(f"<p class=bad>mu_ac is not fitted: {esc(law.note)}.</p>")
    parts.append("<h3>Points without a result</h3>" + (grid(("point", "series", "set-point", "outcome", "reason"), missing)
                                                       if missing else "<p>None.</p>"))
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


def page(analyses, figures, tables, given, notes):
    """figures: (name, title, caption, SVG); tables: for each campaign (rows of the paper, fits); given: contents of --fits."""
    title = " / ".join(dict.fromkeys(a.campaign.title for a in analyses)) or "campaign"
    parts = [f'<!doctype html><html lang="en"><head><meta charset="utf-8"><title>{esc(title)}</title>',
             '<meta http-equiv="Content-Security-Policy"'
             " content=\"default-src 'none'; img-src data:; style-src 'unsafe-inline'\">",
             '<meta name="viewport" content="width=device-width, initial-scale=1">', f"<style>{STYLE}</style></head><body>",
             f"<h1>{esc(title)}</h1>",
             '<nav><a href="#figures">Figures</a><a href="#paper">The paper beside us</a><a href="#fits">Fits</a>'
             '<a href="#budgets">Budgets</a>',
             *(f'<a href="#campaign{k}">{esc(a.campaign.label)}</a>' for k, a in enumerate(analyses)),
             "</nav>"]
    parts += [f"<p><b>{esc(a.campaign.label)}</b>: {esc(summary(a))}</p>" for a in analyses]
    parts += [f"<p class=bad>{esc(note)}</p>" for note in notes]
    parts.append('<h2 id="figures">Figures</h2><div class="figures">' + "".join(figure(*f) for f in figures) + "</div>")
    parts.append('<h2 id="paper">The paper beside us</h2><p class=weak>Maza-Cuello and Maza, Efficient transport controlled by'
                 " biharmonic frictional driving. Truth: of a simulated bench. z counts the errors of this page only.</p>")
    if len(analyses) > 1:
        parts.append("<h3>Side by side</h3><p class=weak>z: difference from the first campaign over the errors of both.</p>"
                     + compared([a.campaign.label for a in analyses], [rows for rows, _ in tables]))
    for a, (rows, _) in zip(analyses, tables):
        parts.append(f"<h3>{esc(a.campaign.label)}</h3>" + (paper_table(rows) if rows else "<p>No points with a result.</p>"))
    parts.append('<h2 id="fits">Fits</h2>')
    if given.get("fits"):
        parts.append("<h3>shakerd mu</h3>" + fit_rows(given["fits"]))
    for a, (_, fits) in zip(analyses, tables):
        if not given.get("fits"):
            parts.append(f"<h3>{esc(a.campaign.label)}</h3>" + (fit_rows(fits) if fits else "<p>No points with a result.</p>"))
    parts.append('<h2 id="budgets">Budgets</h2>' + budget_part(given.get("budgets")))
    parts += [campaign_part(a, k) for k, a in enumerate(analyses)]
    return "\n".join(parts) + "\n</body></html>\n"
