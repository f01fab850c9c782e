"""
Components and strength
=======================

The strength should be constant; after a fit it nearly is.
"""

from magbench.reports.plots.inspection import draw_strength

import magbench

found = magbench.inspect("../../logs/flight.bin")
draw_strength(found.sensors[0])
