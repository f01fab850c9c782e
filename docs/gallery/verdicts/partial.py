"""
Verdict: partial
================

A cause is found, and something is left.
"""

import magbench

recording, truth = magbench.simulate(
    "flight.toml",
    overrides=[
        "effects.offset_jump.time_s=40",
        "effects.offset_jump.step_nT=[40,-60,30]",
        "navigation.attitude_noise_std_deg=0.005",
    ],
)
found = magbench.diagnose(recording, "flight.toml")
print(found)
found.plot()
