"""
A quadrotor's climbing circles
==============================

Wind and gusts push the vehicle; its tilt follows from its acceleration.
"""

from magbench.reports.plots.motion import draw_path

import magbench

outcome = magbench.run("quad-spiral", overrides=["phases.0.duration_s=60"])
draw_path(outcome)
