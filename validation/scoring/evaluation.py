"""Calibrators on one simulated run: fitted, scored against its truth, and the row of no calibration beside them."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

from calib import Calibration, Reference, Status
from recordings import Recording
from sim.effects.base import Effect
from validation.calibrating.calibrator_entry import CalibratorEntry
from validation.calibrating.fitting import SensorFit, sensor_fits, sensor_recordings
from validation.scoring.hold_out import Environment, hold_out
from validation.scoring.scores import Score, score

UNCORRECTED = "uncorrected"
"""The row of the raw measurement, offset 0 and matrix I: what a calibration has to beat."""


@dataclass(frozen=True)
class ScoredCalibration:
    """One calibrator's answer on one sensor: as fitted, and its scores."""

    fit: SensorFit
    scores: list[Score]


def score_calibrators(
    recording: Recording,
    effects: Sequence[Sequence[Effect]],
    reference: Reference,
    chosen: Sequence[CalibratorEntry],
    rng: Callable[[], np.random.Generator] = lambda: np.random.default_rng(0),
    progress: Callable[[float], object] = lambda part: None,
) -> dict[str, ScoredCalibration]:
    """Every calibrator, and last the measurement as it is, by the key of each: `name` or, of an array, `name@sensor`.

    effects : each sensor's true ones, in the chain's order; rng : makes the generator that each fit begins with.
    """
    assert reference.field_enu_nT is not None
    surroundings = Environment.of(recording, reference.field_enu_nT)
    truths = [hold_out(one, surroundings) for one in effects]
    free = {key: one.attitude_free for one in chosen for key in sensor_recordings(recording, one.name)}
    found = [*sensor_fits(recording, reference, chosen, rng, progress), *_uncorrected(recording)]
    return {
        fit.key: ScoredCalibration(
            fit, score(fit.calibration, fit.recording, truths[fit.sensor], free.get(fit.key, False))
        )
        for fit in found
    }


def has_estimate(calibration: Calibration) -> bool:
    """Whether the calibrator estimated anything; a failure that leaves offset 0 and matrix I did not."""
    if calibration.status.kind in ("ok", "not_applicable"):
        return calibration.status.kind == "ok"
    raw = not calibration.offset_nT.any() and np.array_equal(calibration.matrix, np.eye(3))
    return not raw or calibration.eddy_s is not None


def _uncorrected(recording: Recording) -> list[SensorFit]:
    nothing = Calibration(name=UNCORRECTED, status=Status("ok"))
    parts = sensor_recordings(recording, UNCORRECTED)
    return [SensorFit(key, sensor, one, nothing, 0.0) for sensor, (key, one) in enumerate(parts.items())]
