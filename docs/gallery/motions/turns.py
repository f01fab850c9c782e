"""
Three turns about the body's axes
=================================

A turn about each axis gives three circles, then all together.
"""

from magbench.reports.plots.inspection import draw_directions

import magbench

recording, truth = magbench.simulate("turntable-three-turns")
draw_directions(truth.field_nT)
