"""
A sensor and a navigation that are turned
=========================================

The sensor's turn changes the measurement; navigation's changes the attitude that a calibrator is given.
"""

import matplotlib.pyplot as plt
import numpy as np

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
axes[0].plot(recording.time_s, truth.effects["misalignment"], label=["x", "y", "z"])
axes[0].set(title="misalignment", ylabel="nT")
axes[0].legend(loc="right")
same = np.abs(np.sum(recording.att_q * truth.q, axis=1)).clip(max=1)
axes[1].plot(recording.time_s, 2 * np.degrees(np.arccos(same)))
axes[1].set(title="attitude_misalignment: navigation from the truth", ylabel="degrees", xlabel="time (s)")
