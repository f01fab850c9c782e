"""
What a fit leaves
=================

The residual of the fit over time: motors, not noise.
"""

from magbench.reports.plots.inspection import draw_residual

import magbench

found = magbench.inspect("../../logs/flight.bin")
draw_residual(found.sensors[0])
