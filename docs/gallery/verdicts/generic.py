"""
Verdict: generic
================

Slow noise that many causes could give.
"""

from magbench.reports.plots.diagnosis import draw_spectrum

import magbench

recording, truth = magbench.simulate(
    "flight.toml",
    overrides=[
        "effects.offset_random_walk.std_nT_sqrt_s=[0.15,0.15,0.15]",
    ],
)
found = magbench.diagnose(recording, "flight.toml")
print(found)
draw_spectrum(found.presented)
