"""
Motor currents, and their ripple
================================

The field of a supply current, and of its pulsation.
"""

import matplotlib.pyplot as plt

import magbench

recording, truth = magbench.simulate(
    "quad-calibration",
    overrides=[
        "phases.0.duration_s=5",
        "phases.1.duration_s=40",
        "phases.2.duration_s=5",
        "effects.motor_current.gain_nT_A=[6, -4, 9]",
        "effects.current_ripple.amplitude_nT_A=[0.5, 0.5, 0.8]",
        "effects.current_ripple.frequency_hz=2.3",
    ],
)
figure, axes = plt.subplots(2, 1, figsize=(9, 4.6), sharex=True, layout="constrained")
for axis, name in zip(axes, ["motor_current", "current_ripple"], strict=True):
    axis.plot(recording.time_s, truth.effects[name], label=["x", "y", "z"])
    axis.set(title=name, ylabel="nT")
axes[0].legend(loc="right")
axes[-1].set_xlabel("time (s)")
