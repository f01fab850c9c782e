"""Offset of a vehicle that cannot turn: one known attitude and the field vector of a world model."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

import numpy as np
from scipy.spatial.transform import Rotation

from calib.base import Calibrator
from calib.numerics.colour import inflation
from calib.numerics.rates import world_to_body
from calib.reference import Reference
from calib.result import OFFSET_NAMES, Calibration, Status
from calib.settings import NotNegative
from recordings import Recording
from scenarios.arrays import Array
from scenarios.text import figure

OFFSET_ALONE = "the offset alone, for attitudes near the recorded one: soft iron counts as offset"
MOST_TURN_DEG = 5.0
"""Rms turn of the attitude up to which a vehicle counts as one that does not turn."""


@dataclass(frozen=True)
class FixedAttitude(Calibrator):
    """Offset from one known attitude: for a vehicle that cannot turn.

    b = mean(m) - mean(R^T h);  C = V sigma^2 / n + attitude_std^2 (|h|^2 I - h h^T) + field_std^2 I

    h is the reference vector in the world, R the recorded attitude or else that of `heading_deg` (of x, clockwise from
    north), `pitch_deg` (nose up) and `roll_deg` (right side down). `field_std_nT`: error of the reference vector, by
    default that of a world model over land, where rocks add some hundred nT. V: factor of coloured noise.
    """

    name: ClassVar[str] = "fixed_attitude"
    summary: ClassVar[str] = "offset from one known attitude and the field vector, for a vehicle that cannot turn"
    needs: ClassVar[tuple[str, ...]] = ("field_vector",)
    min_samples: ClassVar[int] = 2
    one_axis: ClassVar[bool] = True
    own_judgement: ClassVar[bool] = True
    heading_deg: float | None = None
    pitch_deg: float = 0.0
    roll_deg: float = 0.0
    field_std_nT: NotNegative = 150.0

    def _solve(self, recording: Recording, reference: Reference, rng: np.random.Generator) -> Calibration | Status:
        q = self._attitude(recording)
        if q is None:
            return Status("not_applicable", f"{self.name} needs the attitude: record att_qw, ..., or give heading_deg")
        turn_deg = float(np.degrees(np.sqrt(np.mean(rotation_angles(q) ** 2))))
        if turn_deg > MOST_TURN_DEG:
            what = f"the vehicle turns, by {figure(turn_deg)} degrees rms"
            return Status("not_applicable", f"{what}: take vector_least_squares or ellipsoid")
        field_nT = world_to_body(q, np.array(reference.field_enu_nT))
        error_nT = recording.mag_nT - field_nT
        mean_nT, across = field_nT.mean(axis=0), np.eye(3) * reference.strength_nT**2
        across -= np.outer(mean_nT, mean_nT)
        noise = np.cov(error_nT.T) * inflation(error_nT - error_nT.mean(axis=0)) / len(recording)
        offset_nT = error_nT.mean(axis=0)
        return Calibration(
            name=self.name,
            status=Status("ok", OFFSET_ALONE),
            offset_nT=offset_nT,
            parameters=dict(zip(OFFSET_NAMES, offset_nT.tolist(), strict=True)),
            covariance=noise + self.attitude_std_rad**2 * across + self.field_std_nT**2 * np.eye(3),
            covariance_names=OFFSET_NAMES,
        )

    def _attitude(self, recording: Recording) -> Array | None:
        """Attitudes (n, 4) or (1, 4), body FLU to world ENU: as stated, else as recorded; None for neither."""
        if self.heading_deg is None:
            return recording.att_q
        turn = Rotation.from_euler("ZYX", [90.0 - self.heading_deg, -self.pitch_deg, self.roll_deg], degrees=True)
        return np.asarray(turn.as_quat(scalar_first=True))[None]


def rotation_angles(q: Array) -> Array:
    """Angles (n,), rad, between attitudes q (n, 4) and their mean."""
    turns = Rotation.from_quat(q, scalar_first=True)
    return np.asarray((turns.mean().inv() * turns).magnitude())
