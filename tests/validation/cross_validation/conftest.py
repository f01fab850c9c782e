"""Recordings of a sensor that turns smoothly, made with numpy alone."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from recordings import Recording
from scenarios.arrays import Array

FIELD_ENU_NT = (1_500.0, 19_000.0, -44_000.0)
STRENGTH_NT = float(np.linalg.norm(FIELD_ENU_NT))
SPANS = {"tumble": (1.2, 2.5), "spiral": (0.35, 0.3)}
"""Amplitudes of pitch and roll, rad."""
Made = Callable[..., Recording]


def turning(kind: str, n: int, rng: np.random.Generator) -> tuple[Array, Rotation]:
    """Times and attitudes: a steady yaw, pitch and roll that swing, phases and rates drawn."""
    time_s = 0.5 * np.arange(n)
    yaw, pitch, roll = rng.uniform(0.7, 1.3, (3, 1)) * [[0.1], [0.05], [0.034]] * time_s + rng.uniform(0, 6.3, (3, 1))
    span = SPANS[kind]
    angles = np.column_stack([yaw, span[0] * np.sin(pitch), span[1] * np.sin(roll)])
    return time_s, Rotation.from_euler("ZYX", angles)


def soft_iron(size: float, rng: np.random.Generator) -> Array:
    """S (3, 3) symmetric, off the identity by entries of a size."""
    drawn = size * rng.standard_normal((3, 3))
    return np.asarray(np.eye(3) + (drawn + drawn.T) / 2.0)


@pytest.fixture
def made() -> Made:
    """A recording m = S h + b + what is `added` (n, 3) + white noise, with attitude where asked."""

    def make(
        rng: np.random.Generator,
        matrix: Array,
        *,
        kind: str = "spiral",
        n: int = 600,
        noise_nT: float = 5.0,
        added: Array | float = 0.0,
        attitude: bool = False,
        warmth: Array | None = None,
    ) -> Recording:
        time_s, attitudes = turning(kind, n, rng)
        field = attitudes.inv().apply(FIELD_ENU_NT)
        mag = field @ matrix.T + [2_000.0, -1_000.0, 3_000.0] + added + noise_nT * rng.standard_normal((n, 3))
        q = attitudes.as_quat(scalar_first=True) if attitude else None
        return Recording(time_s, mag, att_q=q, temperature_degC=warmth)

    return make
