"""
A bent characteristic
=====================

The curvature of the sensor's characteristic, against the field: a parabola and a cubic together.
"""

import matplotlib.pyplot as plt

import magbench

recording, truth = magbench.simulate(
    "tumble",
    overrides=[
        "effects.nonlinearity.second_order=[0.004, 0.002, -0.001]",
        "effects.nonlinearity.third_order=[0.004, 0, 0]",
    ],
)
field = recording.mag_nT[:, 0] / 1000
figure, axis = plt.subplots(figsize=(6, 4), layout="constrained")
axis.plot(field, truth.effects["nonlinearity"][:, 0], ".", markersize=2)
axis.set(title="nonlinearity, axis x", xlabel="measured field (µT)", ylabel="nT")
