"""Presentation of a corrected recording: whether the strength varies less than before, what was applied, what to do."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Self

import numpy as np

from calib.models.scalar_terms import CHANNEL
from reports.presentation.calibration import PresentedFit
from scenarios.arrays import Array
from validation.calibrating.calibration_file import AppliedFile
from validation.text import counted, figure, sentence

MUCH = 0.5
"""A correction is told to have helped where the strength varies by less than this share of before."""


@dataclass(frozen=True)
class StrengthChange:
    """Mean and standard deviation of a field's strength in nT, before and after a correction."""

    mean_nT: tuple[float, float]
    std_nT: tuple[float, float]

    @classmethod
    def of(cls, before: Array, after: Array) -> Self:
        """Of strengths (n,), or of fields (n, 3)."""
        sizes = [strength(one) for one in (before, after)]
        first, second = (float(np.nanmean(one)) for one in sizes)
        return cls((first, second), (float(np.nanstd(sizes[0])), float(np.nanstd(sizes[1]))))

    @property
    def share(self) -> float:
        """The variation after, as a share of before; 1 where there was none."""
        before, after = self.std_nT
        return after / before if before > 0 else 1.0

    def summary(self) -> dict[str, list[float]]:
        """Return the JSON: each a pair, before and after."""
        return {"mean_nT": [*self.mean_nT], "std_nT": [*self.std_nT]}


@dataclass(frozen=True)
class PresentedCorrection:
    """What page and terminal show of a corrected recording; changes : by calibration, an array's `name@1` ..."""

    title: str
    calibration: str
    out: Path
    answer: str
    good: bool
    changes: Mapping[str, StrengthChange]
    fits: tuple[PresentedFit, ...]
    steps: tuple[str, ...]
    notes: tuple[str, ...]

    @classmethod
    def of(cls, applied: AppliedFile, calibration: Path, data: Path, out: Path) -> Self:
        """Compare the strength before and after; calibration, data, out : the files."""
        changes = {key: StrengthChange.of(measured(applied, key), found) for key, found in applied.found.items()}
        worst = max(changes.values(), key=lambda one: one.share)
        return cls(
            title=data.name,
            calibration=str(calibration),
            out=out,
            answer=_answer(worst, len(changes)),
            good=worst.share < MUCH,
            changes=changes,
            fits=tuple(PresentedFit.of(key, fit, {}) for key, fit in applied.used.items()),
            steps=tuple(_steps(worst, applied, calibration, data)),
            notes=applied.recording.origin.notes,
        )


def measured(applied: AppliedFile, key: str) -> Array:
    """Return what was measured before the correction: a field (n, 3), or a scalar magnetometer's strength (n,)."""
    part = applied.parts[key]
    return part.channels[CHANNEL] if applied.scalar else part.mag_nT


def strength(values: Array) -> Array:
    """Return the lengths of fields (n, 3), or strengths (n,) as they are."""
    return values if values.ndim == 1 else np.asarray(np.linalg.norm(values, axis=1))


def _answer(worst: StrengthChange, sensors: int) -> str:
    before, after = (figure(std) for std in worst.std_nT)
    of = "" if sensors == 1 else f" of the worst of {counted(sensors, 'sensor')}"
    varies = f"The strength{of} varies by {before} nT (standard deviation) as measured, by {after} nT corrected"
    if worst.share < MUCH:
        return f"{varies}: the calibration fits the recording."
    if worst.share < 1.0:
        return f"{varies}: the calibration takes off little, and may be of another sensor or time."
    return f"{varies}: the calibration does not fit the recording."


def _steps(worst: StrengthChange, applied: AppliedFile, calibration: Path, data: Path) -> list[str]:
    """What to do next: the check of an old calibration, the causes of the rest, a fit of the recording itself."""
    check = f"Does the calibration still hold, and within how many degrees? `magbench recheck {calibration} {data}`"
    rest = f"What is left, and why? `magbench diagnose {data}`"
    again = f"Calibrate the recording itself: `magbench calibrate {data} -o out`"
    doubts = [
        sentence(f"{key} is {fit.status.kind.replace('_', ' ')}: {fit.status.reason}")
        for key, fit in applied.used.items()
        if fit.status.kind != "ok"
    ]
    if applied.scalar:
        return doubts
    return [*doubts, check, rest] if worst.share < MUCH else [*doubts, check, again]
