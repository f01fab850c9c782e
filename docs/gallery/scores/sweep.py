"""
A score over the noise
======================

Every calibrator gets the same trials at each noise.
"""

from magbench.reports.plots.comparison import draw_over

import magbench

found = magbench.compare(
    "tumble",
    trials=4,
    with_=["sphere", "ellipsoid"],
    sweep=["noise_std_nT=5,50,500"],
    overrides=["phases.0.duration_s=60"],
)
draw_over(found.table, found.answers[0].score, found.table.swept[0])
