"""
Ranks over trials
=================

How often each calibrator was first, second, third.
"""

from magbench.reports.plots.comparison import draw_ranks

import magbench

found = magbench.compare(
    "tumble", trials=10, with_=["sphere", "ellipsoid", "twostep"], overrides=["phases.0.duration_s=60"]
)
draw_ranks(found.table, found.answers[0].score, 0)
