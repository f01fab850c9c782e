"""
The Earth's field: a wrong reference, and the day's change
==========================================================

A reference that is off is a constant in the world, so that it turns in the body; the day's change is slow.
"""

import matplotlib.pyplot as plt

import magbench

recording, truth = magbench.simulate(
    "tumble",
    overrides=[
        "phases.0.duration_s=100",
        "effects.regional_field.error_enu_nT=[150, -80, 60]",
        "effects.diurnal_drift.amplitude_enu_nT=[10, -20, 30]",
        "effects.diurnal_drift.period_s=300",
    ],
)
figure, axes = plt.subplots(2, 1, figsize=(9, 4.6), sharex=True, layout="constrained")
for axis, name in zip(axes, ["regional_field", "diurnal_drift"], strict=True):
    axis.plot(recording.time_s, truth.effects[name], label=["x", "y", "z"])
    axis.set(title=name, ylabel="nT")
axes[0].legend(loc="right")
axes[-1].set_xlabel("time (s)")
