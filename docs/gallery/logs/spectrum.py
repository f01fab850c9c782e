"""
Spectrum of the residual
========================

Lines would be tones; here the motors' slow field rises to the left.
"""

from magbench.reports.plots.inspection import draw_spectrum

import magbench

found = magbench.inspect("../../logs/flight.bin")
draw_spectrum(found.sensors[0])
