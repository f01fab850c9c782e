"""What a vehicle's log tells of itself, kept in the metadata of a Parquet file that is made from the log."""

from __future__ import annotations

import datetime
from typing import Annotated, Self

import numpy as np
from pydantic import BaseModel, Field, FiniteFloat, TypeAdapter

from recordings.applied import AppliedCalibration
from recordings.recording import STATED, Origin

LOG_KEY = "magbench_log"
"""The key of the metadata; a simulated run has none."""
Three = Annotated[list[FiniteFloat], Field(min_length=3, max_length=3)]


class KeptCalibration(BaseModel, extra="forbid", frozen=True):
    """An `AppliedCalibration` as JSON."""

    autopilot: str
    compass: int
    offset_nT: Three
    matrix: Annotated[list[Three], Field(min_length=3, max_length=3)]
    parameters: dict[str, FiniteFloat]
    undone: bool

    @classmethod
    def of(cls, found: AppliedCalibration) -> Self:
        """Return the calibration in plain values."""
        plain = {"offset_nT": found.offset_nT.tolist(), "matrix": found.matrix.tolist()}
        return cls(**(vars(found) | plain | {"parameters": dict(found.parameters)}))

    def applied(self) -> AppliedCalibration:
        """Return the calibration with its arrays."""
        arrays = {"offset_nT": np.array(self.offset_nT), "matrix": np.array(self.matrix)}
        return AppliedCalibration(**(vars(self) | arrays))


class LogFacts(BaseModel, extra="forbid", frozen=True):
    """The part of an `Origin` that holds for the columns of a recording, whatever file they are in."""

    unit: str = "nT"
    frame: str = ""
    magnetometer: str = ""
    place: list[FiniteFloat] | None = None
    date: datetime.date | None = None
    applied: KeptCalibration | None = None

    @classmethod
    def of(cls, origin: Origin) -> Self:
        """Return the facts of a recording."""
        applied = None if origin.applied is None else KeptCalibration.of(origin.applied)
        place = None if origin.place is None else list(origin.place)
        own = {name: getattr(origin, name) for name in ("unit", "frame", "magnetometer", "date")}
        return cls(place=place, applied=applied, **own)

    def __bool__(self) -> bool:
        return self != LogFacts()


FACTS = TypeAdapter(LogFacts)
NOTHING = LogFacts.of(STATED)
