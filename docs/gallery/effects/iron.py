"""
Hard and soft iron
==================

Permanent magnetism is constant in the body, induced magnetism follows the field.
"""

import matplotlib.pyplot as plt

import magbench

recording, truth = magbench.simulate(
    "tumble",
    overrides=[
        "phases.0.duration_s=100",
        "effects.soft_iron.matrix=[[0.1, 0.01, 0.02], [-0.03, 0.05, 0.03], [0.04, 0.01, 0.02]]",
    ],
)
figure, axes = plt.subplots(2, 1, figsize=(9, 4.6), sharex=True, layout="constrained")
for axis, name in zip(axes, ["hard_iron", "soft_iron"], strict=True):
    axis.plot(recording.time_s, truth.effects[name], label=["x", "y", "z"])
    axis.set(title=name, ylabel="nT")
axes[0].legend(loc="right")
axes[-1].set_xlabel("time (s)")
