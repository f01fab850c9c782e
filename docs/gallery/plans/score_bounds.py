"""
Bounds on the scores
====================

Heading and field errors that no calibration can go below, over the amplitude.
"""

from magbench.reports.plots.bound import draw_score_bounds

import magbench

draw_score_bounds(magbench.what_if("standard-auv", "roll_amplitude_deg=5:40:5", "norm"))
