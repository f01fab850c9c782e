"""
The bound over a motion's amplitude
===================================

How far must an AUV roll? The least error of the offset over the amplitude.
"""

import magbench

magbench.what_if("standard-auv", "roll_amplitude_deg=5:40:5", "norm").plot()
