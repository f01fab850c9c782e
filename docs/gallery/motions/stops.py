"""
Twelve stops about the vertical
===============================

Twelve points on one circle: enough for some errors, not for all.
"""

from magbench.reports.plots.inspection import draw_directions

import magbench

recording, truth = magbench.simulate("turntable-twelve-stops")
draw_directions(truth.field_nT)
