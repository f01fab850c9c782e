"""Presentation of calibrations of a recording: the answer, figures with intervals, and where the residual is large."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Self

import numpy as np

from calib import Calibration, Reference
from calib.result import OFFSET_NAMES
from recordings import Recording
from validation.assessment.assessment import Assessment
from validation.assessment.wording import calibration_summary, summary, tolerance_texts, verdict
from validation.calibrating.residual_parts import by_channel, by_phase, strength_residual
from validation.text import figure, measured, sentence

NORMAL_95 = 1.96
"""Half of the 95 % interval in standard deviations."""
MOST_CHANNELS = 6
PHASE_HEADS = ("phase", "samples", "mean, nT", "rms, nT")
CHANNEL_HEADS = ("channel", "share of the residual's variance, %", "nT a unit")
Tile = tuple[str, str, str]
Row = tuple[str, ...]


@dataclass(frozen=True)
class PresentedFit:
    """A calibration's figures as texts: offset with the half of its 95 % interval, matrix by rows, errors."""

    name: str
    status: str
    reason: str
    heading: str
    strength: Row
    offset: Row
    matrix: tuple[Row, ...]

    def row(self) -> dict[str, str]:
        """Return the texts by the heads of a table."""
        before, after = self.strength
        figures = dict(zip(("offset x, nT", "offset y, nT", "offset z, nT"), self.offset, strict=True))
        rms = {"strength before, nT": before, "after, held out, nT": after}
        return {"calibrator": self.name, "status": self.status, "heading error [95 %]": self.heading, **rms, **figures}

    @classmethod
    def of(cls, name: str, fit: Calibration, assessed: Mapping[str, Any]) -> Self:
        """Describe a calibration; assessed : its part of an assessment's summary, empty for none."""
        rms = assessed.get("strength_rms") or {}
        return cls(
            name=name,
            status=fit.status.kind.replace("_", " "),
            reason=sentence(fit.status.reason) if fit.status.reason else "",
            heading=interval(assessed.get("heading_error_deg")),
            strength=(_figure(rms.get("before")), _figure(rms.get("after_held_out"))),
            offset=tuple(offset_texts(fit)),
            matrix=tuple(_matrix(fit)),
        )


@dataclass(frozen=True)
class PresentedCalibrations:
    """What page, terminal and notebook show of the calibrations of a recording.

    Parameters
    ----------
    best : the calibration that figures and residual are of; None where no fit has an estimate.
    phases, channels : rows of PHASE_HEADS and CHANNEL_HEADS.
    """

    title: str
    headline: str
    doubts: tuple[str, ...]
    tiles: tuple[Tile, ...]
    fits: tuple[PresentedFit, ...]
    best: str | None
    tolerance: tuple[str, ...]
    phases: tuple[Row, ...]
    channels: tuple[Row, ...]
    notes: tuple[str, ...]

    @classmethod
    def of(
        cls,
        title: str,
        results: Mapping[str, Calibration],
        recording: Recording,
        reference: Reference,
        assessment: Assessment,
        doubts: Sequence[str] = (),
    ) -> Self:
        """Compute all texts; doubts : sentences about faults of the recording."""
        parts = {name: calibration_summary(one) for name, one in assessment.calibrations.items()}
        best, answer = assessment.recommended or None, assessment.tolerance
        phases, channels = _residual(results, recording, reference, best)
        return cls(
            title=title,
            headline=sentence(verdict(assessment)),
            doubts=(*doubts, *(sentence(text) for text in assessment.trust.doubts)),
            tiles=tuple(_tiles(summary(assessment), parts.get(best or "", {}))),
            fits=tuple(PresentedFit.of(name, fit, parts.get(name, {})) for name, fit in results.items()),
            best=best,
            tolerance=tuple(sentence(text) for text in tolerance_texts(answer)) if answer else (),
            phases=phases,
            channels=channels,
            notes=recording.origin.notes,
        )


def interval(found: Mapping[str, float | None] | None, unit: str = "°") -> str:
    """Return "1.2° [0.9, 1.7]" for a value with its 95 % interval; a dash for none."""
    if not found or found.get("value") is None:
        return "–"
    ends = [figure(float(found[end]), 2) for end in ("low", "high") if found.get(end) is not None]  # type: ignore[arg-type]
    return f"{figure(float(found['value'] or 0.0), 2)}{unit}" + (f" [{', '.join(ends)}]" if ends else "")


def of_sensor(recording: Recording, key: str) -> Recording:
    """Return the recording of the sensor that a key `name@sensor` names; of a single magnetometer the recording."""
    _, _, sensor = key.partition("@")
    return recording.sensor(int(sensor) - 1) if sensor and recording.array_mag_nT is not None else recording


def _figure(value: float | None) -> str:
    return "–" if value is None else figure(float(value))


def offset_texts(fit: Calibration) -> list[str]:
    """Return x, y and z of the offset with the half of the 95 % interval, nT; dashes without an estimate."""
    if not fit.has_estimate:
        return ["–"] * 3
    std = () if fit.covariance is None else np.diag(fit.covariance) ** 0.5
    wide = dict(zip(fit.covariance_names, std, strict=False))
    texts = []
    for name, value in zip(OFFSET_NAMES, fit.offset_nT, strict=True):
        known = name in wide or fit.determines_z or name != OFFSET_NAMES[2]
        text = measured(float(value), NORMAL_95 * float(wide[name])) if name in wide else figure(float(value))
        texts.append(text if known else "–")
    return texts


def _matrix(fit: Calibration) -> list[Row]:
    return [tuple(f"{value:.5f}" for value in row) for row in fit.matrix] if fit.has_estimate else []


def _tiles(assessed: Mapping[str, Any], best: Mapping[str, Any]) -> list[Tile]:
    """Return value, unit and label of the figures at the top of the page."""
    rms, coverage = best.get("strength_rms") or {}, best.get("coverage")
    tiles = [(interval(best.get("heading_error_deg")), "", "heading error on a level survey, rms, 95 % interval")]
    if rms.get("before") is not None and rms.get("after_held_out") is not None:
        change = f"{figure(rms['before'])} → {figure(rms['after_held_out'])}"
        tiles.append((change, "nT", "strength's rms deviation, before and on held-out legs"))
    words = (("quality", "quality"), ("trust", "trust"), ("use", "what to use"))
    tiles += [(str(assessed[key]), "", label) for key, label in words if assessed.get(key)]
    if coverage is not None:
        tiles.append((figure(100 * float(coverage), 2), "%", "of the sphere's directions seen"))
    return tiles


def _residual(
    results: Mapping[str, Calibration], recording: Recording, reference: Reference, best: str | None
) -> tuple[tuple[Row, ...], tuple[Row, ...]]:
    """Return the rows of PHASE_HEADS and of CHANNEL_HEADS; none where no calibration is recommended."""
    if best is None:
        return (), ()
    measured = of_sensor(recording, best)
    residual = strength_residual(results[best], measured, reference)
    phases = ((one.phase, f"{one.samples}", one.mean_nT, one.rms_nT) for one in by_phase(residual, measured))
    channels = ((one.channel, 100 * one.share, one.slope_nT) for one in by_channel(residual, measured)[:MOST_CHANNELS])
    return tuple(map(_texts, phases)), tuple(map(_texts, channels))


def _texts(row: Sequence[str | float]) -> Row:
    return tuple(cell if isinstance(cell, str) else figure(cell) for cell in row)
