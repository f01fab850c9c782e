"""
An AUV's comb
=============

A survey in lines over an object on the seabed.
"""

from magbench.reports.plots.motion import draw_path

import magbench

outcome = magbench.run(
    "auv-comb",
    overrides=[
        "phases.0.lines=3",
        "phases.0.line_length_m=40",
        "phases.0.run_in_s=10",
    ],
)
draw_path(outcome)
