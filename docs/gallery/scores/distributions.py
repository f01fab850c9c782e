"""
A score over trials
===================

Whiskers to the 5th and 95th percentile, quartiles as bar, median as dot.
"""

import magbench

found = magbench.compare(
    "tumble", trials=10, with_=["sphere", "ellipsoid", "twostep"], overrides=["phases.0.duration_s=60"]
)
found.plot()
