"""
A quadrotor's comb
==================

Lines at 7 m/s with turns between them.
"""

from magbench.reports.plots.motion import draw_path

import magbench

outcome = magbench.run(
    "quad-comb",
    overrides=[
        "phases.0.lines=3",
        "phases.0.line_length_m=60",
        "phases.0.run_in_s=5",
    ],
)
draw_path(outcome)
