"""Physics: geomagnetic field, vehicles in MuJoCo, and the magnetometer as a chain of effects."""

import os

os.environ.setdefault("MUJOCO_GL", "disable")
"""Nothing is drawn: else MuJoCo looks for a window system in a child process, noisy where one is killed."""
