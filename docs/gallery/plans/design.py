"""
The design behind a plan
========================

Weights of attitudes that a convex search gives.
"""

from magbench.reports.plots.plan import draw_design

import magbench

draw_design(magbench.plan("hand", 60))
