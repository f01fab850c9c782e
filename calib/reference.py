"""Reference: the strength of the Earth's field, or the vector."""

from __future__ import annotations

import math
from dataclasses import dataclass

from scenarios.errors import InputError

AGREEMENT = 1e-3
"""Largest relative difference between a strength and a vector given together."""


@dataclass(frozen=True)
class Reference:
    """The undisturbed field: strength, nT, and where known the vector (east, north, up), nT.

    Raises InputError when a value is not finite, the strength not positive, or the two contradict each other.
    """

    strength_nT: float
    field_enu_nT: tuple[float, float, float] | None = None

    def __post_init__(self) -> None:
        if not (math.isfinite(self.strength_nT) and self.strength_nT > 0):
            raise InputError(
                f"the field strength must be a positive number of nT, not {self.strength_nT}", where="reference"
            )
        if self.field_enu_nT is not None:
            self._check_vector(self.field_enu_nT)

    def _check_vector(self, vector: tuple[float, ...]) -> None:
        if len(vector) != 3 or not all(math.isfinite(v) for v in vector):
            raise InputError(
                f"the field vector must be three finite numbers (east, north, up), not {tuple(vector)}",
                where="reference",
            )
        if abs(math.hypot(*vector) - self.strength_nT) > AGREEMENT * self.strength_nT:
            raise InputError(
                f"the field vector is {math.hypot(*vector):.1f} nT long but the strength is {self.strength_nT:.1f} nT",
                where="reference",
                do="give the vector alone",
            )

    @classmethod
    def of_vector(cls, field_enu_nT: tuple[float, float, float]) -> Reference:
        """The reference of a known field vector (east, north, up), nT."""
        east, north, up = (float(v) for v in field_enu_nT)
        return cls(math.hypot(east, north, up), (east, north, up))
