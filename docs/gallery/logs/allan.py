"""
Allan deviation of a log
========================

White noise for a second, then slow changes.
"""

from magbench.reports.plots.inspection import draw_allan

import magbench

found = magbench.inspect("../../logs/flight.bin")
draw_allan(found.sensors[0])
