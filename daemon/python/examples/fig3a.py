"""Fig. 3a of the paper from a campaign's folder: drift velocity against phi for each gamma.

    python3 fig3a.py FOLDER fig3a.png
"""
import sys

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt
import numpy as np
import shakerd

with shakerd.Campaign(sys.argv[1]) as campaign:
    points = campaign.measured
    gammas = points["asked_gamma"].value
    for gamma in np.unique(gammas):
        line = points.where(gammas == gamma)
        v = line["v_D"].to("mm/s", 1e3)
        plt.errorbar(line["phi"].value, v.value, 2 * v.error, fmt="o", label=f"{gamma / 9.81:.2f} g")
plt.xlabel("phi (rad)")
plt.ylabel("v_D (mm/s), bars: 95 %")
plt.legend()
plt.savefig(sys.argv[2])
