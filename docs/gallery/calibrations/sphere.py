"""
Before and after, on the sphere
===============================

The colour is the deviation of the strength.
"""

import magbench

found = magbench.calibrate("../../logs/flight.bin", with_="motor_ellipsoid:battery")
found.plot()
