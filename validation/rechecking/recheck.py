"""Verdict on an old calibration: valid, changed, cannot tell.

valid        with 99 % confidence the change turns no heading of a level survey by the tolerance, and no change shows
changed      a change of the offset, the soft iron or a motor's field shows: significant at 1 %, and not negligible
cannot tell  neither: the log is too short, too noisy, or its motion does not determine what matters
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Literal

import numpy as np

from calib import Calibration, Reference
from calib.observability import remedy_text
from recordings import Recording
from scenarios.arrays import Array
from scenarios.errors import InputError
from validation.calibrating.correction import corrected_field
from validation.rechecking.change import ChangeEstimate, estimate_change
from validation.rechecking.heading import HeadingErrors, dip_of, heading_columns
from validation.rechecking.logged_inputs import with_logged_inputs
from validation.rechecking.noise import WeightedCovariances
from validation.rechecking.old_claim import with_old
from validation.rechecking.parts import FALSE_ALARM, OUTSIDE, PartChange, changed_parts, motors_seen
from validation.rechecking.tails import size_found
from validation.screening.screening import screen
from validation.text import figure

Answer = Literal["valid", "changed", "cannot tell"]
TOLERANCE_DEG = 1.0
"""Heading error by a change, from which on the change matters, where the user states none."""
WRONG_VALID = 0.01
"""Chance at most that "valid" is said of a calibration whose change makes an error of the tolerance: each heading must
exclude it alone (intersection of one-sided tests), so that no heading's test needs a correction."""
POWER = 0.95
"""Chance with which a change of the stated size is found."""
LEAST_SAMPLES = 30
"""Samples below which a log is not looked at."""
TURNED = "S_yx"
"""Parameter of an old calibration whose matrix was determined by attitude."""


@dataclass(frozen=True, eq=False)
class Recheck:
    """The answer on an old calibration.

    heading_deg : largest heading error of the change on a level survey, with the ends of its 95 % interval.
    excluded_deg : the least error that is excluded with 99 % confidence. found_nT : offset change in any direction that
    the log would have shown in 95 of 100 cases. parts : changes of each part. reason : why the log does not tell, and
    what would help. notes : what was assumed. unit : of offsets, nT or counts.
    """

    verdict: Answer
    tolerance_deg: float
    heading_deg: tuple[float, float, float]
    excluded_deg: float
    found_nT: float
    parts: tuple[PartChange, ...]
    reason: str = ""
    notes: tuple[str, ...] = ()
    knowledge: str = "strength"
    unit: str = "nT"

    @property
    def changes(self) -> tuple[PartChange, ...]:
        """Return the significant changes."""
        return tuple(part for part in self.parts if part.significant)


def recheck(
    old: Calibration, recording: Recording, reference: Reference | None, tolerance_deg: float = TOLERANCE_DEG
) -> Recheck:
    """Return whether an old calibration still holds for the instrument of a recording.

    reference : None takes the strength from the log as the old calibration corrects it; a common scale is then unseen.
    Raises InputError for a tolerance that is not positive, and a calibration without a usable estimate.
    """
    if not (np.isfinite(tolerance_deg) and tolerance_deg > 0):
        raise InputError(f"{tolerance_deg} is no tolerance", where="--tolerance-deg", do="give a positive number")
    screening = screen(recording, reference)
    notes = [fault.told for fault in screening.faults]
    doubtful = [fault.told for fault in screening.faults if fault.doubtful]
    seen = screening.recording
    if len(seen) < LEAST_SAMPLES:
        return _unknown(tolerance_deg, f"{len(seen)} samples are too few: record {LEAST_SAMPLES} or more", notes)
    old, told = with_logged_inputs(old, seen)
    notes += told
    corrected = replace(seen, mag_nT=corrected_field(old, seen, old.name), array_mag_nT=None)
    if reference is None:
        reference = Reference(float(np.median(np.linalg.norm(corrected.mag_nT, axis=1))))
        notes.append("the field is not known: its strength is taken as the old calibration gives it")
    if old.status.reason:
        notes.append(old.status.reason)
    found = _judged(old, corrected, reference, tolerance_deg, notes)
    if doubtful:
        return replace(found, verdict="cannot tell", reason="; ".join(doubtful))
    return found


def _unknown(tolerance_deg: float, reason: str, notes: list[str]) -> Recheck:
    nothing = (float("nan"), 0.0, float("inf"))
    return Recheck("cannot tell", tolerance_deg, nothing, float("inf"), float("inf"), (), reason, tuple(notes))


def _judged(
    old: Calibration, corrected: Recording, reference: Reference, tolerance_deg: float, notes: list[str]
) -> Recheck:
    """Return the verdict on a recording whose field the old calibration corrects."""
    vector = _by_vector(old, corrected, reference)
    unit = "nT" if corrected.origin.unit == "nT" else "counts"
    estimate = _with_motors_if_seen(corrected, reference, vector)
    dip_rad, known_by = dip_of(corrected, reference)
    if known_by.startswith("assumed"):
        notes.append(f"the dip of the field is {known_by}; state the field vector, or place and date")
    spread = with_old(old, estimate)
    errors = HeadingErrors.of(estimate, spread, heading_columns(estimate, dip_rad))
    excluded_deg = errors.excluded(WRONG_VALID)
    parts = changed_parts(old, estimate, spread, dip_rad, unit)
    verdict = _verdict(excluded_deg, tolerance_deg, parts)
    return Recheck(
        verdict,
        tolerance_deg,
        errors.interval(OUTSIDE),
        excluded_deg,
        _found_nT(old, spread, len(parts) + 1),
        parts,
        _missing(spread.mean, excluded_deg, tolerance_deg) if verdict == "cannot tell" else "",
        tuple(dict.fromkeys(notes)),
        "vector" if vector else "strength",
        unit,
    )


def _verdict(excluded_deg: float, tolerance_deg: float, parts: tuple[PartChange, ...]) -> Answer:
    """Return the answer; of a change of the scale alone the field's strength may be the cause."""
    if any(part.shows(tolerance_deg) for part in parts):
        return "changed"
    return "valid" if excluded_deg < tolerance_deg else "cannot tell"


def _by_vector(old: Calibration, corrected: Recording, reference: Reference) -> bool:
    """Whether attitude and field vector are used: the old matrix was determined so, and no autopilot made the attitude.

    An autopilot takes its heading from the magnetometer that is to be judged.
    """
    known = corrected.att_q is not None and reference.field_enu_nT is not None
    return known and TURNED in old.covariance_names and corrected.origin.applied is None


def _with_motors_if_seen(corrected: Recording, reference: Reference, vector: bool) -> ChangeEstimate:
    """Return the estimate with motor terms where they are significant together, else without them."""
    estimate = estimate_change(corrected, reference, vector=vector)
    if estimate.motors and not motors_seen(estimate):
        return estimate_change(corrected, reference, vector=vector, motors=False)
    return estimate


def _found_nT(old: Calibration, spread: WeightedCovariances, tests: int) -> float:
    """Return the offset change, in the direction where it is seen worst, that the test finds with POWER."""
    back = np.linalg.inv(old.matrix)
    offsets = back @ spread.covariances[:, :3, :3] @ back.T
    worst = np.linalg.eigh(np.tensordot(spread.weights, offsets, 1))[1][:, -1]
    variances = np.asarray(worst @ offsets @ worst)
    return size_found(variances, spread.weights, FALSE_ALARM / tests, POWER, 3)


def _missing(covariance: Array, excluded_deg: float, tolerance_deg: float) -> str:
    """Return why the log does not decide, and what motion would."""
    axis = np.linalg.eigh(covariance[:3, :3])[1][:, -1]
    what = f"a heading error of {figure(excluded_deg, 2)} deg is not excluded (tolerance {tolerance_deg:g} deg)"
    return f"{what}, and no change is significant; record longer, and {remedy_text(axis)}"
