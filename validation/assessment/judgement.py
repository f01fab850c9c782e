"""Quality of a calibration by its heading error, trust in the figures, and the answer to a tolerance."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Literal

from calib import Calibration
from validation.assessment.causes import Causes
from validation.assessment.coverage import Coverage
from validation.assessment.heading_error import TURNED, HeadingError
from validation.assessment.held_out import LegAgreement
from validation.assessment.input_fields import unmodelled
from validation.assessment.policy import ASSESSMENT
from validation.assessment.posterior import Posterior
from validation.screening.fault import Fault
from validation.text import listed

AXES_KINDS = ("turned", "left_handed", "reversed", "frame")
"""Faults of a recording's axes."""
QualityWord = Literal["good", "fair", "bad"]
TrustWord = Literal["high", "medium", "low"]
Answer = Literal["yes", "no", "undecidable"]


@dataclass(frozen=True)
class Trust:
    """Trust in the figures in a word, with what speaks against them, in clauses."""

    word: TrustWord
    doubts: tuple[str, ...]


@dataclass(frozen=True)
class DecidingLeg:
    """The shortest planned legs that would decide a tolerance, and how long they last."""

    sentence: str
    duration_s: float


@dataclass(frozen=True)
class ToleranceAnswer:
    """Whether the heading error is below a tolerance at 95 %, its causes, and where undecidable what would decide."""

    tolerance_deg: float
    answer: Answer
    probability: float
    causes: Causes | None
    next_leg: DecidingLeg | None = None
    wrong_axes: str = ""


def quality_of(fit: Calibration, error: HeadingError | None, tolerance_deg: float) -> QualityWord:
    """Return good where the interval is below the tolerance, bad where the median is above, fair between.

    A fit that is not ok is fair at best; one without a heading error is bad.
    """
    if error is None or error.value > tolerance_deg:
        return "bad"
    return "good" if fit.status.kind == "ok" and error.high < tolerance_deg else "fair"


def axes_fault(fit: Calibration, faults: Sequence[Fault]) -> str:
    """Return the clause about axes that are not the vehicle's, and that the fit does not turn; "" for right axes."""
    kinds = ("left_handed", "frame") if TURNED in fit.covariance_names else AXES_KINDS
    return next((fault.text for fault in faults if fault.kind in kinds), "")


def answer_of(error: HeadingError | None, tolerance_deg: float) -> tuple[Answer, float]:
    """Return the answer to a tolerance, and the probability that the error is below."""
    if error is None:
        return "undecidable", 0.5
    below = error.below(tolerance_deg)
    if below >= ASSESSMENT.sure:
        return "yes", below
    return ("no" if below <= 1.0 - ASSESSMENT.sure else "undecidable"), below


def trust_of(
    fit: Calibration,
    posterior: Posterior | None,
    agreement: LegAgreement | None,
    coverage: Coverage,
    faults: Sequence[Fault],
) -> Trust:
    """Return the trust: high without a doubt, medium with one, low with more or with a serious one."""
    serious = tuple(_serious(fit, agreement, faults))
    directions = coverage if fit.determines_z else None
    doubts = (*serious, *_doubts(fit, posterior, agreement, directions, faults))
    if serious or len(doubts) > 1:
        return Trust("low", doubts)
    return Trust("medium" if doubts else "high", doubts)


def _serious(fit: Calibration, agreement: LegAgreement | None, faults: Sequence[Fault]) -> Iterator[str]:
    if axes_fault(fit, faults):
        yield "the axes are not the vehicle's: the heading holds once they are"
    if fit.status.kind != "ok":
        yield f"the calibration is {fit.status.kind.replace('_', ' ')}"
    if agreement is not None and agreement.share < ASSESSMENT.least_agree:
        yield f"only {agreement.sentence}"
    if any(fault.doubtful for fault in faults):
        yield "the recording has a fault that makes every estimate doubtful"


def _doubts(
    fit: Calibration,
    posterior: Posterior | None,
    agreement: LegAgreement | None,
    coverage: Coverage | None,
    faults: Sequence[Fault],
) -> Iterator[str]:
    if agreement is None:
        yield "no legs to compare"
    elif ASSESSMENT.least_agree <= agreement.share < ASSESSMENT.most_agree:
        yield f"only {agreement.sentence}"
    if coverage is not None and coverage.share < ASSESSMENT.least_coverage:
        missing = f": {listed(coverage.missing)} missing" if coverage.missing else ""
        yield f"the directions cover {100 * coverage.share:.0f} % of the sphere{missing}"
    if posterior is not None:
        yield from _loose(fit, posterior)
    if any(fault.remedy != "left out" and not fault.doubtful for fault in faults):
        yield "the screening found a fault"


def _loose(fit: Calibration, posterior: Posterior) -> Iterator[str]:
    if not posterior.determined:
        yield "the motion does not determine the matrix"
    if posterior.likeliest.scatter > ASSESSMENT.most_scatter:
        yield "the legs scatter more than white noise"
    yield from (f"the field of the {name} is not taken off" for name in unmodelled(fit, posterior))
