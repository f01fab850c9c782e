"""
A steady tone in the spectrum
=============================

Mains or a payload: a line in the spectrum, wherever the vehicle turns.
"""

import matplotlib.pyplot as plt

import magbench

recording, truth = magbench.simulate(
    "tumble", overrides=["effects.steady_tone.amplitude_nT=[30, -20, 40]", "effects.steady_tone.frequency_hz=3.7"]
)
figure, axis = plt.subplots(figsize=(8, 3.4), layout="constrained")
axis.psd(truth.effects["steady_tone"][:, 2] + truth.effects["white_noise"][:, 2], NFFT=1024, Fs=10)
axis.set(title="tone and white noise, axis z", xlabel="frequency (Hz)")
