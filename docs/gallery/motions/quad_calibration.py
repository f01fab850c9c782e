"""
A quadrotor sways while it yaws
===============================

Attitude, rates and currents while the vehicle calibrates on the spot.
"""

from magbench.reports.plots.motion import draw_vehicle

import magbench

outcome = magbench.run(
    "quad-calibration",
    overrides=[
        "phases.0.duration_s=5",
        "phases.1.duration_s=40",
        "phases.2.duration_s=5",
    ],
)
draw_vehicle(outcome)
