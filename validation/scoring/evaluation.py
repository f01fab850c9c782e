"""Calibrators fitted to a simulated run and scored against the truth, with the uncorrected measurement."""

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
"""Name of the raw measurement's row, offset 0 and matrix I, which a calibration has to beat."""


@dataclass(frozen=True)
class ScoredCalibration:
    """The fit of a calibrator to a sensor, with scores."""

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
    """Fit and score every calibrator, and last the raw measurement; by key `name`, of an array `name@sensor`.

    effects : the true effects of each sensor, in the order of the chain. rng : makes a new generator for each fit.
    """
    assert reference.field_enu_nT is not None
    environment = Environment.of(recording, reference.field_enu_nT)
    truths = [hold_out(one, environment) for one in effects]
    free = {key: one.attitude_free for one in chosen for key in sensor_recordings(recording, one.name)}
    fits = [*sensor_fits(recording, reference, chosen, rng, progress), *_uncorrected(recording)]
    return {
        fit.key: ScoredCalibration(
            fit, score(fit.calibration, fit.recording, truths[fit.sensor], free.get(fit.key, False))
        )
        for fit in fits
    }


def _uncorrected(recording: Recording) -> list[SensorFit]:
    nothing = Calibration(name=UNCORRECTED, status=Status("ok"))
    parts = sensor_recordings(recording, UNCORRECTED)
    return [SensorFit(key, sensor, one, nothing, 0.0) for sensor, (key, one) in enumerate(parts.items())]
