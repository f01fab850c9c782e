"""
Kinds of noise by their Allan deviation
=======================================

White noise falls with the square root of time, flicker noise stays, a Gauss-Markov process has a hump.
"""

import matplotlib.pyplot as plt
from magbench.validation.signals.noise import allan_deviation

import magbench

kinds = {
    "white_noise": "effects.white_noise.std_nT=[5, 5, 5]",
    "flicker_noise": "effects.flicker_noise.density_nT_sqrt_hz=[2, 2, 2]",
    "gauss_markov_noise": "effects.gauss_markov_noise.std_nT=[3, 3, 3]",
}
recording, truth = magbench.simulate("tumble", overrides=[*kinds.values(), "phases.0.duration_s=2000"])
figure, axis = plt.subplots(figsize=(8, 4), layout="constrained")
for name in kinds:
    tau_s, deviation_nT = allan_deviation(0.1, truth.effects[name][:, :1])
    axis.loglog(tau_s, deviation_nT, label=name)
axis.set(xlabel="averaging time (s)", ylabel="Allan deviation (nT)")
axis.legend()
