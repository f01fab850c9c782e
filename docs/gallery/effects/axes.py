"""
Axes that are not square and not alike
======================================

Both are linear in the field: an ellipsoid in place of a sphere.
"""

import matplotlib.pyplot as plt

import magbench

recording, truth = magbench.simulate(
    "tumble",
    overrides=[
        "phases.0.duration_s=100",
        "effects.non_orthogonality.angles_deg=[1, -0.5, 0.7]",
        "effects.scale.error=[0.1, -0.05, 0.02]",
    ],
)
figure, axes = plt.subplots(2, 1, figsize=(9, 4.6), sharex=True, layout="constrained")
for axis, name in zip(axes, ["non_orthogonality", "scale"], strict=True):
    axis.plot(recording.time_s, truth.effects[name], label=["x", "y", "z"])
    axis.set(title=name, ylabel="nT")
axes[0].legend(loc="right")
axes[-1].set_xlabel("time (s)")
