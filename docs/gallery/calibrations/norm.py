"""
The strength along a survey
===========================

Raw and corrected strength beside the reference.
"""

from magbench.reports.plots.field import draw_norm

import magbench

draw_norm(magbench.run("auv-comb", overrides=["phases.0.lines=3", "phases.0.line_length_m=40"]))
