"""
The last digits
===============

A converter's step shows in the digits: ArduPilot logs whole milligauss.
"""

from magbench.reports.plots.inspection import draw_low_digits

import magbench

found = magbench.inspect("../../logs/flight.bin")
draw_low_digits(found.sensors[0])
