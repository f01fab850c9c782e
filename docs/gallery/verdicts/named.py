"""
Verdict: named
==============

One cause, here a motor's current: the gap against the channel.
"""

from magbench.reports.plots.diagnosis import draw_channel

import magbench

recording, truth = magbench.simulate(
    "flight.toml",
    overrides=[
        "effects.motor_current.gain_nT_A=[4,-2,8]",
    ],
)
found = magbench.diagnose(recording, "flight.toml")
print(found)
draw_channel(found.presented)
