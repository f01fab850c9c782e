"""
Verdict: none
=============

Model and recording agree: before and after are the same noise.
"""

import magbench

recording, truth = magbench.simulate("flight.toml")
found = magbench.diagnose(recording, "flight.toml")
print(found)
found.plot()
