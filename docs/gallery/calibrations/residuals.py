"""
What calibrators leave, against the truth
=========================================

The corrected field minus the true one, in the body frame.
"""

from magbench.reports.plots.field import draw_residuals

import magbench

draw_residuals(magbench.run("standard-full", overrides=["calibrators=['sphere', 'ellipsoid', 'vector_least_squares']"]))
