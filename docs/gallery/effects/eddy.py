"""
Eddy currents
=============

Turning in the field induces currents, whose field follows the rate of change.
"""

import matplotlib.pyplot as plt

import magbench

recording, truth = magbench.simulate(
    "tumble",
    overrides=[
        "phases.0.duration_s=100",
        "effects.eddy_current.matrix_s=[[0.1, 0.01, 0.02], [-0.03, 0.05, 0.03], [0.04, 0.01, 0.02]]",
        "effects.eddy_current.time_constant_s=0.1",
    ],
)
figure, axis = plt.subplots(figsize=(9, 3.2), layout="constrained")
axis.plot(recording.time_s, truth.effects["eddy_current"], label=["x", "y", "z"])
axis.set(title="eddy_current", xlabel="time (s)", ylabel="nT")
axis.legend(loc="right")
