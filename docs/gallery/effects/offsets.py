"""
Offsets: constant, jumping, wandering
=====================================

A jump keeps its size, a random walk grows with the square root of time.
"""

import matplotlib.pyplot as plt

import magbench

recording, truth = magbench.simulate(
    "tumble",
    overrides=[
        "phases.0.duration_s=100",
        "effects.sensor_offset.offset_nT=[-10, 20, 30]",
        "effects.offset_jump.time_s=40",
        "effects.offset_jump.step_nT=[50, -20, 10]",
        "effects.offset_random_walk.std_nT_sqrt_s=[2, 2, 2]",
    ],
)
figure, axes = plt.subplots(3, 1, figsize=(9, 6.3), sharex=True, layout="constrained")
for axis, name in zip(axes, ["sensor_offset", "offset_jump", "offset_random_walk"], strict=True):
    axis.plot(recording.time_s, truth.effects[name], label=["x", "y", "z"])
    axis.set(title=name, ylabel="nT")
axes[0].legend(loc="right")
axes[-1].set_xlabel("time (s)")
