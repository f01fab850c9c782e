"""Physics: geomagnetic field, vehicles in MuJoCo, the magnetometer chain with its effects, the dataset."""

import os

from sim.compiled import keep_somewhere

keep_somewhere()
os.environ.setdefault("MUJOCO_GL", "disable")
"""Nothing is drawn: else MuJoCo looks for a window system in a child process, noisy where one is killed."""
