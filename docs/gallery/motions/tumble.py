"""
A tumble covers the sphere
==========================

A three-axis turntable shows the sensor every direction of the field.
"""

from magbench.reports.plots.inspection import draw_directions

import magbench

recording, truth = magbench.simulate("tumble")
draw_directions(truth.field_nT)
