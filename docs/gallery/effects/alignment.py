"""
A sensor and a navigation that are turned
=========================================

The sensor's turn acts in the body, navigation's in the world: the same degree, another picture.
"""

import matplotlib.pyplot as plt

import magbench

recording, truth = magbench.simulate(
    "tumble",
    overrides=[
        "phases.0.duration_s=100",
        "effects.misalignment.angles_deg=[1, -2, 3]",
        "effects.attitude_misalignment.angles_deg=[0.5, -1, 2]",
    ],
)
figure, axes = plt.subplots(2, 1, figsize=(9, 4.6), sharex=True, layout="constrained")
for axis, name in zip(axes, ["misalignment", "attitude_misalignment"], strict=True):
    axis.plot(recording.time_s, truth.effects[name], label=["x", "y", "z"])
    axis.set(title=name, ylabel="nT")
axes[0].legend(loc="right")
axes[-1].set_xlabel("time (s)")
