"""A sweep of phi on a bench on call, driven from Python.

    python3 live_sweep.py http://127.0.0.1:8080 [TOKEN]
"""
import sys

import numpy as np
import shakerd

bench = shakerd.Bench(*sys.argv[1:3]).ready()
for phi in np.radians([110, 300, 115, 305]):  # every second one walks back
    bench.drive(gamma=9.81, phi=phi)
    result = bench.measure(periods=10)
    v, asked = result["v_D"].to("mm/s", 1e3), result["phi"]
    print(f"phi {asked.value:.4f} rad: v_D {v.value:+.4f} +- {v.error:.4f} mm/s", flush=True)
bench.stop()
bench.wait("idle")
