"""
Every score of a run
====================

Scores whose unit is nT, of each calibrator: less is better. In-sample scores never rank.
"""

import matplotlib.pyplot as plt

import magbench

table = magbench.run("tumble", overrides=["phases.0.duration_s=120"]).to_frame()
names = [name for name in table if name.endswith(("_rms", "error", "merit")) and name != "heading_rms"]
figure, axis = plt.subplots(figsize=(9, 5), layout="constrained")
table[names].astype(float).T.plot.barh(ax=axis, logx=True)
axis.set_xlabel("nT (the matrix error has no unit)")
