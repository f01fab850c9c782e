"""
Spikes and dropouts
===================

Single wrong values, and gaps in which the last value is repeated; a fit leaves such rows out.
"""

import matplotlib.pyplot as plt

import magbench

recording, truth = magbench.simulate(
    "tumble",
    overrides=[
        "phases.0.duration_s=100",
        "effects.spikes.rate_hz=0.2",
        "effects.spikes.amplitude_nT=300",
        "effects.dropouts.rate_hz=0.1",
        "effects.dropouts.mean_duration_s=0.5",
    ],
)
figure, axes = plt.subplots(2, 1, figsize=(9, 4.6), sharex=True, layout="constrained")
for axis, name in zip(axes, ["spikes", "dropouts"], strict=True):
    axis.plot(recording.time_s, truth.effects[name], label=["x", "y", "z"])
    axis.set(title=name, ylabel="nT")
axes[0].legend(loc="right")
axes[-1].set_xlabel("time (s)")
