"""How closely each calibrator must give back a noise-free recording; a calibrator without a line has the default.

The default asks of a stranger's method what any honest one holds: where it says ok it is right to 5 % of the field.
A line asks more, and is the place to say what the method's model cannot hold.
"""

from __future__ import annotations

from dataclasses import dataclass

MOTIONS = ("full", "pitch", "auv")


@dataclass(frozen=True)
class Expected:
    """recovers: standard motions on which it must say ok. corrects: it gives offset and matrix of the vector sensor.
    offset_nT, matrix: largest error without noise; turned: largest change with noise in another frame, unit or order.
    unit_free: no setting is in nT. scale_alone: the model holds one scale and no soft iron.
    """

    recovers: tuple[str, ...] = ()
    corrects: bool = True
    offset_nT: float = 1846.0
    matrix: float = 0.2
    turned_nT: float = 1846.0
    turned_matrix: float = 0.2
    unit_free: bool = True
    scale_alone: bool = False


def _exact(*recovers: str, scale_alone: bool = False) -> Expected:
    """To rounding, and for an iterative method its own tolerance."""
    return Expected(recovers, True, 0.02, 1e-6, 1e-3, 1e-7, scale_alone=scale_alone)


FILTER = Expected(("full", "pitch"), True, 5.0, 2e-4, 0.25, 2e-5, unit_free=False)
"""A prior and settings in nT stay in the answer."""
EXPECTED = {
    "sphere": _exact(*MOTIONS, scale_alone=True),
    **dict.fromkeys(("ellipsoid", "ellipsoid_segmented", "twostep", "ml_newton", "ml_geometric"), _exact(*MOTIONS)),
    **dict.fromkeys(("pso", "ga", "psoga", "vector_least_squares", "vector_lm"), _exact(*MOTIONS)),
    **dict.fromkeys(("ide_gradiometer", "de_gradiometer", "ga_gradiometer"), _exact(*MOTIONS)),
    **dict.fromkeys(("least_squares_gradiometer", "two_step_gradiometer"), _exact(*MOTIONS)),
    **dict.fromkeys(("gyro_ml", "gyro_accel_ml"), Expected(MOTIONS, True, 5.0, 2e-4, 1e-2, 1e-6)),
    "strength_dip": Expected(MOTIONS, True, 0.1, 1e-5, 0.5, 1e-5),
    "ukf": Expected(("full", "pitch"), True, 1.0, 2e-5, 0.05, 2e-6),
    **dict.fromkeys(("kalman_rescaled", "kalman_fuzzy"), FILTER),
    "kalman": Expected((), True, 5.0, 2e-4, 0.25, 2e-5, unit_free=False),
    **dict.fromkeys(("motor_ellipsoid", "motor_vector"), Expected(MOTIONS, True, 0.02, 1e-6, 0.5, 1e-4)),
    "tolles_lawson": Expected(corrects=False),
}
SECONDS_A_FIT = ("ide_gradiometer", "de_gradiometer", "ga_gradiometer")
"""Searches over all parameters of an array: the night run alone repeats them much."""


OTHER_SEARCHES = SECONDS_A_FIT[1:]
"""Those that the first stands for by day, where all three go through the same lines."""
SLOW_WITHOUT_ANSWER = ("strength_dip", "gyro_accel_ml", "gyro_ml", "ellipsoid_segmented", "motor_ellipsoid")
"""Calibrators that try for a second or more where the data tell nothing."""


def expected(name: str) -> Expected:
    """What a calibrator must hold."""
    return EXPECTED.get(name, Expected())
