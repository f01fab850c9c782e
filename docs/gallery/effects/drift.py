"""
Iron that drifts
================

Magnetism that relaxes after a shock: fast at first, then slower.
"""

import matplotlib.pyplot as plt

import magbench

recording, truth = magbench.simulate(
    "tumble",
    overrides=[
        "phases.0.duration_s=100",
        "effects.hard_iron_drift.rate_nT_h=[3000, -9000, 15000]",
        "effects.hard_iron_drift.time_constant_s=30",
    ],
)
figure, axis = plt.subplots(figsize=(9, 3.2), layout="constrained")
axis.plot(recording.time_s, truth.effects["hard_iron_drift"], label=["x", "y", "z"])
axis.set(title="hard_iron_drift", xlabel="time (s)", ylabel="nT")
axis.legend(loc="right")
