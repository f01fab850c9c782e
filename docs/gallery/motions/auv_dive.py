"""
An AUV's dive: descent, spiral, comb, ascent
============================================

Ballast drives descent and ascent; between them the vehicle circles and surveys.
"""

from magbench.reports.plots.motion import draw_path

import magbench

outcome = magbench.run(
    "auv-dive",
    overrides=[
        "phases.0.to_depth_m=8",
        "phases.1.run_in_s=10",
        "phases.1.duration_s=60",
        "phases.1.turns=",
        "phases.2.lines=2",
        "phases.2.line_length_m=30",
        "phases.2.run_in_s=5",
        "phases.3.to_depth_m=3",
    ],
)
draw_path(outcome)
