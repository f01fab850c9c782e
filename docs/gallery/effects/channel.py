"""
An effect of any channel
========================

A curve of a logged channel, here of the temperature: linear, square and cubic.
"""

import matplotlib.pyplot as plt

import magbench

recording, truth = magbench.simulate(
    "tumble",
    overrides=[
        "phases.0.duration_s=100",
        "thermal.initial_degC=5",
        "thermal.time_constant_s=30",
        "effects.channel_effect.channel=temperature_degC",
        "effects.channel_effect.centre=20",
        "effects.channel_effect.scale=4",
        "effects.channel_effect.linear_nT=[20, -10, 30]",
        "effects.channel_effect.square_nT=[4, 3, -5]",
    ],
)
figure, axis = plt.subplots(figsize=(9, 3.2), layout="constrained")
axis.plot(recording.time_s, truth.effects["channel_effect"], label=["x", "y", "z"])
axis.set(title="channel_effect", xlabel="time (s)", ylabel="nT")
axis.legend(loc="right")
