"""
Verdict: class
==============

A kind of cause: two candidates that this recording cannot distinguish.
"""

from magbench.reports.plots.diagnosis import draw_ranking

import magbench

recording, truth = magbench.simulate(
    "flight.toml",
    overrides=[
        "effects.latency.delay_s=0.0006",
    ],
)
found = magbench.diagnose(recording, "flight.toml")
print(found)
draw_ranking(found.presented)
