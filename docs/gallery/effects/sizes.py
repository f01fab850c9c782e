"""
All effects of a run by size
============================

The contributions of a survey's effects, by their rms.
"""

from magbench.reports.plots.effects import draw_effect_sizes

import magbench

outcome = magbench.run("quad-comb", overrides=["phases.0.lines=2", "phases.0.line_length_m=60", "phases.0.run_in_s=5"])
draw_effect_sizes(outcome)
