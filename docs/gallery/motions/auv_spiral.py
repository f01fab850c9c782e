"""
An AUV's circles with roll and pitch
====================================

Commanded roll and pitch turn the body away from the vertical, which level circles never do.
"""

from magbench.reports.plots.motion import draw_path

import magbench

outcome = magbench.run("auv-spiral-excited", overrides=["phases.0.run_in_s=10", "phases.0.duration_s=120"])
draw_path(outcome)
