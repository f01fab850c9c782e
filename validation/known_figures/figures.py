"""A figure of another program, and the log with its calibration that figures are taken from."""

from __future__ import annotations

from dataclasses import asdict, dataclass
from functools import cached_property
from typing import Any

import numpy as np

from calib import Calibration, Reference
from calib.models.sphere import SphereFit
from calib.numerics.points import lengths
from calib.numerics.rates import world_to_body
from recordings import Recording
from scenarios.arrays import Array
from scenarios.plain import json_ready
from validation.text import figure

HEADS = ("program", "figure", "here", "its limit", "passes")


@dataclass(frozen=True)
class KnownFigure:
    """A program's figure on a log.

    value : None where the log does not give it, with the reason in `note`. limit : with `at_most` an upper one, else a
    lower one; None where the program has none.
    """

    program: str
    name: str
    value: float | None
    unit: str
    limit: float | None
    at_most: bool = True
    note: str = ""

    @property
    def passes(self) -> bool | None:
        """Return whether the program's limit passes the log; None without a value or a limit."""
        if self.value is None or self.limit is None:
            return None
        return bool(self.value <= self.limit if self.at_most else self.value >= self.limit)

    def summary(self) -> dict[str, Any]:
        """Return plain values for JSON."""
        return json_ready(asdict(self) | {"passes": self.passes})  # type: ignore[no-any-return]

    def row(self) -> list[str]:
        """Return the cells of HEADS."""
        bound = "-" if self.limit is None else f"{'at most' if self.at_most else 'at least'} {figure(self.limit)}"
        here = self.note if self.value is None else f"{figure(self.value)} {self.unit}".rstrip()
        return [self.program, self.name, here, bound, {True: "yes", False: "no", None: "-"}[self.passes]]


@dataclass(frozen=True, eq=False)
class CalibratedLog:
    """Measured and calibrated field (n, 3), nT, the field's strength, and the known field in the body frame or None."""

    calibration: Calibration
    measured_nT: Array
    field_nT: Array
    strength_nT: float
    known_nT: Array | None

    @classmethod
    def of(cls, calibration: Calibration, recording: Recording, reference: Reference) -> CalibratedLog:
        """Return the log of the samples that the fit used."""
        used = calibration.used(recording) if _of_rows(calibration, recording) else recording
        known = None
        if used.att_q is not None and reference.field_enu_nT is not None:
            known = world_to_body(used.att_q, np.array(reference.field_enu_nT))
        return cls(calibration, used.mag_nT, calibration.apply(used), reference.strength_nT, known)

    @cached_property
    def lengths_nT(self) -> Array:
        """Return the strength of the calibrated field (n,)."""
        return np.asarray(lengths(np.ascontiguousarray(self.field_nT)))

    @cached_property
    def sphere(self) -> tuple[Array, float]:
        """Return centre (3,) and radius of the sphere through the measurements, nT, by linear least squares."""
        middle = self.measured_nT.mean(axis=0)
        found = SphereFit.of(np.ascontiguousarray(self.measured_nT - middle))
        return middle + found.centre, found.radius


def _of_rows(calibration: Calibration, recording: Recording) -> bool:
    return calibration.left_out is not None and len(calibration.left_out) == len(recording)
