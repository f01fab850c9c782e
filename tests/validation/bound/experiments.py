"""Experiments of the standard case, and of motions that tell too little."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from scipy.spatial.transform import Rotation

from tests.calib import conftest as standard
from validation.bound.experiment import Experiment

ACCEL_STD_M_S2 = 0.02


def along(attitude: Rotation, interval_s: float = 0.1) -> Experiment:
    """The standard sensor in the standard field along attitudes."""
    turns = (attitude[1:].inv() * attitude[:-1]).as_matrix()
    field_nT = attitude.inv().apply(standard.FIELD_ENU_NT)
    step_s = np.full(len(turns), interval_s)
    up = attitude.inv().apply([0.0, 0.0, 1.0])
    known = Experiment(field_nT, standard.SOFT, standard.NOISE_STD_NT, turns, step_s)
    return replace(known, up=up, accel_std_m_s2=ACCEL_STD_M_S2)


def of_motion(motion: str, samples: int = 3600) -> Experiment:
    """A standard motion of six minutes."""
    time_s = np.arange(samples) * 360.0 / samples
    return along(standard.attitude(motion, time_s), 360.0 / samples)


def level_turns(samples: int = 3600) -> Experiment:
    """Yaw alone, exactly level."""
    return along(Rotation.from_rotvec(np.outer(0.01 * np.arange(samples), [0.0, 0.0, 1.0])))
