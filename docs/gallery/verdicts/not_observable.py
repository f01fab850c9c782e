"""
Verdict: not_observable
=======================

The motion cannot show the cause: fly otherwise.
"""

import magbench

recording, truth = magbench.simulate(
    "circles.toml",
    overrides=[
        "effects.scale.error=[0.002,-0.001,0]",
    ],
)
found = magbench.diagnose(recording, "circles.toml")
print(found)
found.plot()
