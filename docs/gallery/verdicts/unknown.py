"""
Verdict: unknown
================

A gap that no candidate explains.
"""

from magbench.reports.plots.diagnosis import draw_channel

import magbench

recording, truth = magbench.simulate(
    "flight.toml",
    overrides=[
        "navigation.attitude_noise_std_deg=0.05",
    ],
)
found = magbench.diagnose(recording, "flight.toml")
print(found)
draw_channel(found.presented)
