"""
The least error of each component
=================================

What no method can beat with this motion.
"""

import magbench

magbench.bound("standard-pitch", "norm").plot()
