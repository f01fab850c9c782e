"""Assessment of the calibrations of a recording: how good each is, which to use, and the answer to a tolerance."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

from calib import Calibration, Reference
from validation.assessment.causes import causes_of
from validation.assessment.evidence import CalibrationAssessment, SensorEvidence
from validation.assessment.heading_error import HeadingError
from validation.assessment.held_out import Use
from validation.assessment.judgement import DecidingLeg, QualityWord, ToleranceAnswer, Trust, answer_of
from validation.assessment.policy import ASSESSMENT
from validation.screening.screening import ScreenedRecording


@dataclass(frozen=True, eq=False)
class Assessment:
    """Assessment of every calibration of a recording, and of the recommended one.

    recommended : key of the calibration to use, "" for none. tolerance : the answer where a tolerance was asked for.
    """

    calibrations: dict[str, CalibrationAssessment]
    recommended: str
    use: Use | None
    tolerance: ToleranceAnswer | None

    @property
    def best(self) -> CalibrationAssessment | None:
        """Return the recommended calibration's assessment, None without one."""
        return self.calibrations.get(self.recommended)

    @property
    def quality(self) -> QualityWord:
        """Return the quality of the recommended calibration; bad where none can be recommended."""
        return self.best.quality if self.best else "bad"

    @property
    def trust(self) -> Trust:
        """Return the trust in the recommended calibration's figures."""
        return self.best.trust if self.best else Trust("low", ("no calibration is ok",))


def assess(
    found: Mapping[str, Calibration],
    screening: ScreenedRecording,
    reference: Reference,
    tolerance_deg: float | None = None,
) -> Assessment:
    """Return the assessment of calibrations of a screened recording; of an array by `name@sensor`.

    tolerance_deg : heading error to be answered for; the quality is judged by ASSESSMENT.tolerance_deg without one.
    """
    limit = ASSESSMENT.tolerance_deg if tolerance_deg is None else tolerance_deg
    assessed: dict[str, CalibrationAssessment] = {}
    evidence: dict[str, SensorEvidence] = {}
    for sensor, keys in _by_sensor(found).items():
        own = screening if sensor is None else screening.of_sensor(sensor)
        own_evidence = SensorEvidence.of({_name(key): found[key] for key in keys}, own.recording, reference)
        for key in keys:
            assessed[key], evidence[key] = own_evidence.assessed(key, found[key], own, limit), own_evidence
    best = _best(assessed, "ok")
    known = evidence.get(best, next(iter(evidence.values()), None))
    use = None if known is None else known.use_of(found.get(best))
    answer = None if tolerance_deg is None else _answered(assessed, evidence, tolerance_deg)
    return Assessment(assessed, best, use, answer)


def _name(key: str) -> str:
    """Return the calibrator's name of a key `name@sensor`."""
    return key.partition("@")[0]


def _by_sensor(found: Mapping[str, Calibration]) -> dict[int | None, list[str]]:
    """Return the keys by index of the sensor, None for a single sensor."""
    sensors: dict[int | None, list[str]] = {}
    for key in found:
        _, at, number = key.partition("@")
        sensors.setdefault(int(number) - 1 if at else None, []).append(key)
    return sensors


def _best(assessed: Mapping[str, CalibrationAssessment], *kinds: str) -> str:
    """Return the key of the least heading error among calibrators of some statuses on every sensor, "" for none.

    Of an array the worst sensor counts.
    """
    worst: dict[str, tuple[float, str]] = {}
    for key, one in assessed.items():
        usable = one.heading is not None and one.fit.status.kind in kinds
        value = one.heading.value if one.heading is not None and usable else float("inf")
        worst[_name(key)] = max(worst.get(_name(key), (-1.0, "")), (value, key))
    value, key = min(worst.values(), default=(float("inf"), ""))
    return key if value < float("inf") else ""


def _answered(
    assessed: Mapping[str, CalibrationAssessment], evidence: Mapping[str, SensorEvidence], tolerance_deg: float
) -> ToleranceAnswer:
    """Return the answer by the best calibration; a calibration that is not ok may be answered with no, never yes."""
    ok = _best(assessed, "ok")
    best = ok or _best(assessed, "unobservable", "not_converged")
    if not best:
        return ToleranceAnswer(tolerance_deg, "undecidable", 0.5, None)
    heading, known = assessed[best].heading, evidence[best]
    assert heading is not None
    answer, below = answer_of(heading, tolerance_deg)
    wrong_axes = assessed[best].wrong_axes
    answer = "undecidable" if answer == "yes" and (not ok or wrong_axes) else answer
    posterior = known.posterior_for(assessed[best].fit)
    causes = None if posterior is None else causes_of(posterior, heading.flight.level_nT).left_by(assessed[best].fit)
    undecided = answer == "undecidable" and not wrong_axes
    leg = _deciding_leg(known, heading, tolerance_deg) if undecided else None
    return ToleranceAnswer(tolerance_deg, answer, below, causes, leg, wrong_axes)


def _deciding_leg(known: SensorEvidence, heading: HeadingError, tolerance_deg: float) -> DecidingLeg | None:
    from validation.assessment.shortest_leg import shortest_leg  # plans by the simulator, which other answers lack

    return shortest_leg(known.recording, known.reference, heading, tolerance_deg)
