"""
A plan for a hand
=================

The attitudes of a two-minute calibration by hand, over time.
"""

import magbench

magbench.plan("hand", 60).plot()
