"""
A gradient, and an object on the ground
=======================================

Both depend on the place: the gradient grows along a line, the object is a peak at its closest point.
"""

import matplotlib.pyplot as plt

import magbench

recording, truth = magbench.simulate(
    "quad-comb",
    overrides=[
        "phases.0.lines=2",
        "phases.0.line_length_m=60",
        "phases.0.run_in_s=5",
    ],
)
figure, axes = plt.subplots(2, 1, figsize=(9, 4.6), sharex=True, layout="constrained")
for axis, name in zip(axes, ["field_gradient", "local_dipole"], strict=True):
    axis.plot(recording.time_s, truth.effects[name], label=["x", "y", "z"])
    axis.set(title=name, ylabel="nT")
axes[0].legend(loc="right")
axes[-1].set_xlabel("time (s)")
