"""mu of every campaign below a folder, in the order of their time, with the limits of a control chart.

    python3 mu_archive.py ARCHIVE
"""
import json
import pathlib
import subprocess
import sys

import numpy as np
import shakerd

rows = []
for file in sorted(pathlib.Path(sys.argv[1]).rglob("campaign.nxs")):
    fit = subprocess.run(["shakerd", "mu", str(file.parent), "--json"], capture_output=True, text=True, check=False)
    with shakerd.Campaign(file) as campaign:
        when = campaign.points["time"][0]
    fits = json.loads(fit.stdout)["fits"] if fit.returncode == 0 else []
    mu_ac = next((f for f in fits if f["name"] == "mu_ac" and f["value"] is not None), None)
    if mu_ac is None:
        print(f"{when} {file.parent.name}: no mu_ac; {fit.stderr.strip() or 'too few points'}")
    else:
        rows.append((when, file.parent.name, mu_ac["value"], mu_ac["error"]))
rows.sort()
if not rows:
    sys.exit("no campaign with a mu_ac")
mu, error = (np.array([row[k] for row in rows]) for k in (2, 3))
mean = np.average(mu, weights=error**-2)
for when, name, value, sigma in rows:
    out = abs(value - mean) > 3 * sigma
    print(f"{when} {name}: mu_ac {value:.6f} +- {sigma:.6f}{'  beyond three errors of the mean' if out else ''}")
print(f"mean {mean:.6f}; chi2 per freedom {np.sum(((mu - mean) / error) ** 2) / max(1, len(mu) - 1):.2f}")
