"""
Hysteresis
==========

The core lags behind the field: the curve depends on where the field came from.
"""

import matplotlib.pyplot as plt

import magbench

recording, truth = magbench.simulate(
    "tumble", overrides=["effects.hysteresis.gain=[0.02, 0.01, 0.03]", "effects.hysteresis.threshold_nT=[9000]"]
)
field = recording.mag_nT[:, 0] / 1000
figure, axis = plt.subplots(figsize=(6, 4), layout="constrained")
axis.plot(field, truth.effects["hysteresis"][:, 0], ".", markersize=2)
axis.set(title="hysteresis, axis x", xlabel="measured field (µT)", ylabel="nT")
