"""Table 1 of [Zhang2018] as printed: total field at 30 positions before, and error after each method."""

from __future__ import annotations

import numpy as np

from scenarios.arrays import Array


def _figures(text: str) -> Array:
    return np.array([float(figure) for figure in text.split()])


PRINTED_F_NT = 36141.0
TOTAL_NT = _figures("""
    36044.9 36034.7 36284.0 36330.9 36398.0 36433.4 36403.5 36347.1 35980.8 35994.1
    36261.1 36042.8 36241.5 36242.3 36258.6 36303.1 36341.6 36387.7 36409.0 36398.9
    36376.3 35936.7 35951.7 35970.4 36292.1 36007.5 36259.2 36240.0 36251.4 36274.5
""")
"""Total field before calibration at the 30 positions."""
AFTER_NT = {
    "pso": _figures("""
        60.5 66.1 74.2 80.3 86.2 92.4 89.6 81.0 72.7 67.8
        60.3 53.0 59.1 62.8 68.4 75.9 80.2 86.2 89.8 87.6
        84.6 79.6 73.4 70.5 66.5 62.9 54.3 52.1 57.1 60.2
    """),
    "ga": _figures("""
        46.2 50.4 55.8 61.8 67.5 72.1 68.0 66.8 60.3 53.0
        46.5 40.4 45.4 48.0 52.2 59.7 64.8 68.3 70.2 71.6
        68.0 65.9 61.1 58.3 55.3 50.8 44.5 41.6 49.8 58.2
    """),
    "psoga": _figures("""
        37.3 42.6 46.5 50.0 53.3 57.8 54.4 49.1 44.2 40.7
        35.1 31.5 34.9 37.0 42.4 47.4 50.3 53.6 55.9 52.7
        50.8 47.0 45.2 42.1 40.5 38.6 34.6 30.5 32.9 37.5
    """),
}
"""Absolute error after calibration."""
