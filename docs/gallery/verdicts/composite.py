"""
Verdict: composite
==================

Several causes together.
"""

import magbench

recording, truth = magbench.simulate(
    "flight.toml",
    overrides=[
        "effects.motor_current.gain_nT_A=[4,-2,8]",
        "effects.offset_jump.time_s=40",
        "effects.offset_jump.step_nT=[8,-12,6]",
    ],
)
found = magbench.diagnose(recording, "flight.toml")
print(found)
found.plot()
