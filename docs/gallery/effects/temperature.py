"""
A sensor that warms up
======================

The offset follows the temperature behind a lag; the sensitivity changes with it.
"""

import matplotlib.pyplot as plt

import magbench

recording, truth = magbench.simulate(
    "tumble",
    overrides=[
        "phases.0.duration_s=100",
        "thermal.initial_degC=5",
        "thermal.time_constant_s=30",
        "effects.temperature_scale.slope_1_K=[0.0001, 0.0002, -0.0003]",
        "effects.temperature_offset.slope_nT_K=[8, -6, 10]",
    ],
)
figure, axes = plt.subplots(2, 1, figsize=(9, 4.6), sharex=True, layout="constrained")
for axis, name in zip(axes, ["temperature_offset", "temperature_scale"], strict=True):
    axis.plot(recording.time_s, truth.effects[name], label=["x", "y", "z"])
    axis.set(title=name, ylabel="nT")
axes[0].legend(loc="right")
axes[-1].set_xlabel("time (s)")
