"""Evidence of a sensor's recording on its calibrations, and the assessment of each."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np

from calib import Calibration, Reference
from recordings import Recording
from scenarios.arrays import Array
from validation.assessment.coverage import Coverage
from validation.assessment.heading_error import TURNED, HeadingError, heading_error
from validation.assessment.held_out import HeldOutLegs, LegAgreement, StrengthRms, Use
from validation.assessment.judgement import QualityWord, Trust, axes_fault, quality_of, trust_of
from validation.assessment.level_flight import LevelFlight, level_flight
from validation.assessment.posterior import Posterior, posterior_of
from validation.assessment.sensor_model import group_of
from validation.screening.screening import ScreenedRecording

LEAST_SAMPLES = 24
"""Least number of samples of which legs are held out."""


@dataclass(frozen=True, eq=False)
class CalibrationAssessment:
    """How good a calibration is. None: no estimate, or too few rows.

    heading : error on a level survey. strength : before, and after on held-out legs. agreement : of the legs.
    wrong_axes : the clause about axes that are not the vehicle's; "" for right axes.
    """

    name: str
    fit: Calibration
    heading: HeadingError | None
    strength: StrengthRms | None
    agreement: LegAgreement | None
    coverage: Coverage
    quality: QualityWord
    trust: Trust
    wrong_axes: str = ""


@dataclass(frozen=True, eq=False)
class SensorEvidence:
    """What a sensor's recording tells: posterior, by strength and where known by vector; held-out legs."""

    recording: Recording
    reference: Reference
    flight: LevelFlight
    by_strength: Posterior | None
    by_vector: Posterior | None
    legs: HeldOutLegs | None

    @classmethod
    def of(cls, fits: Mapping[str, Calibration], recording: Recording, reference: Reference) -> SensorEvidence:
        """Return the evidence of a single sensor's recording, with its calibrations by name."""
        sound = recording.taken(np.asarray(np.isfinite(recording.mag_nT).all(axis=1)))
        flight = level_flight(sound, reference, _seen(fits, sound))
        known = sound.att_q is not None and reference.field_enu_nT is not None
        return cls(
            sound,
            reference,
            flight,
            posterior_of(fits, sound, reference, flight, vector=False),
            posterior_of(fits, sound, reference, flight, vector=True) if known else None,
            HeldOutLegs.of(sound, reference) if len(sound) >= LEAST_SAMPLES else None,
        )

    def use_of(self, fit: Calibration | None) -> Use | None:
        """Return what predicts held-out legs, beside the inputs of a calibration; None with too few rows."""
        if self.legs is None:
            return None
        channels = () if fit is None else tuple(term.channel for term in fit.inputs)
        return replace(self.legs.use(), terms=tuple(dict.fromkeys(map(group_of, channels))))

    def posterior_for(self, fit: Calibration) -> Posterior | None:
        """Return the posterior that a calibration is judged by: by vector where the calibration knew it.

        None for a planar calibration, which a level turn determines.
        """
        if not fit.determines_z:
            return None
        return self.by_vector if self.by_vector is not None and TURNED in fit.covariance_names else self.by_strength

    def legs_for(self, fit: Calibration) -> HeldOutLegs | None:
        """Return the held-out legs that a calibration is judged by: beside the fields of its inputs, where it has any.

        Each leg's offset and matrix come from the other legs, the few gains of the inputs from the whole recording.
        """
        if self.legs is None or not fit.inputs:
            return self.legs
        own_nT = np.sum([term.field(self.recording) for term in fit.inputs], axis=0)
        without = replace(self.recording, mag_nT=self.recording.mag_nT - own_nT)
        return replace(HeldOutLegs.of(without, self.reference), raw_nT=self.legs.raw_nT)

    def assessed(
        self, name: str, fit: Calibration, screening: ScreenedRecording, tolerance_deg: float
    ) -> CalibrationAssessment:
        """Return the assessment of a calibration of the recording."""
        estimate = fit.has_estimate and not fit.corrects_scalar
        posterior = self.posterior_for(fit)
        heading = heading_error(fit, posterior, self.flight)
        held_out = self.legs_for(fit) if estimate and fit.determines_z else None
        strength = None if held_out is None else held_out.strength(fit, self.recording, self.reference)
        agreement = None if held_out is None else held_out.agreement(fit)
        coverage = Coverage.of(fit.apply(self.recording) if estimate else self.recording.mag_nT)
        trust = trust_of(fit, posterior, agreement, coverage, screening.faults)
        wrong_axes = axes_fault(fit, screening.faults)
        quality = "bad" if wrong_axes else quality_of(fit, heading, tolerance_deg)
        return CalibrationAssessment(name, fit, heading, strength, agreement, coverage, quality, trust, wrong_axes)


def _seen(fits: Mapping[str, Calibration], recording: Recording) -> Array:
    """Return the field (n, 3) of the first calibration that is ok, else of the first estimate, else as measured."""
    whole = [fit for fit in fits.values() if fit.has_estimate and fit.determines_z and not fit.corrects_scalar]
    best = next((fit for fit in whole if fit.status.kind == "ok"), whole[0] if whole else None)
    return recording.mag_nT if best is None else best.apply(recording)
