"""
A slow sensor, and a late one
=============================

A low-pass and a delay differ from the truth only while the field turns.
"""

import matplotlib.pyplot as plt

import magbench

recording, truth = magbench.simulate(
    "tumble",
    overrides=[
        "phases.0.duration_s=100",
        "effects.bandwidth.cutoff_hz=3",
        "effects.latency.delay_s=0.11",
    ],
)
figure, axes = plt.subplots(2, 1, figsize=(9, 4.6), sharex=True, layout="constrained")
for axis, name in zip(axes, ["bandwidth", "latency"], strict=True):
    axis.plot(recording.time_s, truth.effects[name], label=["x", "y", "z"])
    axis.set(title=name, ylabel="nT")
axes[0].legend(loc="right")
axes[-1].set_xlabel("time (s)")
