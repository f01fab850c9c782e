"""
A level AUV sees a belt
=======================

Roll and pitch of five degrees: the vertical offset is hardly determined.
"""

from magbench.reports.plots.inspection import draw_directions

import magbench

recording, truth = magbench.simulate("standard-auv")
draw_directions(truth.field_nT)
