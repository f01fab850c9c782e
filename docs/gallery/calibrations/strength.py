"""
Strength before and after
=========================

A level line is what a calibration is for.
"""

import magbench

found = magbench.calibrate("../../logs/flight.bin", with_=["ellipsoid", "motor_ellipsoid"])
found.plot()
