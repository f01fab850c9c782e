"""
Directions of a flight's log
============================

A turn by hand, then a flight: the directions that the sensor saw.
"""

from magbench.reports.plots.inspection import draw_coverage

import magbench

found = magbench.inspect("../../logs/flight.bin")
draw_coverage(found.sensors[0])
