"""JSON of `magbench calibrate`, `apply` and `recheck`, and of calibration.json."""

from __future__ import annotations

from typing import Any

from pydantic import RootModel

from reports.schemas.base import CalibrationJson, IntervalJson, ResultTable, Three, ThreeByThree, key, where_told


class HeadingErrorJson(IntervalJson):
    """Expected heading error on a level survey, degrees."""

    dip_deg: float | None = key("dip of the field for which the error holds")
    dip_from: str = key("what the dip is known from")
    yaw_misalignment_included: bool = key("whether a turn of the sensor about the vertical counts")


class StrengthRmsJson(ResultTable):
    """Rms of the field strength's error, nT."""

    before: float | None = key("of the raw measurement")
    after_held_out: float | None = key("of each leg, calibrated by the others")


class LegsJson(ResultTable):
    """Legs that a fit without them predicts."""

    agree: int = key("legs predicted no worse than most")
    legs: int = key("legs in all")


class AssessedCalibrationJson(CalibrationJson):
    """A calibration with what the log tells of its errors."""

    heading_error_deg: HeadingErrorJson | None = key("expected heading error; null where the log does not tell")
    strength_rms: StrengthRmsJson | None = key("error of the field strength; null where the log does not tell")
    coverage: float = key("share of the directions of the sphere that the log shows")
    missing_faces: list[str] = key("faces of the sensor that were never towards the field")
    legs: LegsJson | None = key("agreement of the legs; null without legs")
    quality: str = key("good, fair or bad")
    trust: str = key("how far the figures can be trusted: high, medium or low")


class FaultJson(ResultTable):
    """A fault of the sensor in the recording."""

    kind: str = key("kind, such as saturated, stuck or wrapped")
    text: str = key("in words")
    rows: int = key("number of rows")
    stretches: list[list[int]] = key("first and last row of each stretch, from 1")
    remedy: str = key("what was done: left out, unwrapped or none")
    doubtful: bool = key("whether the fault makes every estimate doubtful")
    sensor: int | None = key("sensor of an array, from 0; null for the recording")
    detail: list[Any] = key("figures of the fault")


class ClaimJson(ResultTable):
    """Claimed standard deviation of the offset against its scatter from leg to leg."""

    ratio: float | None = key("scatter over claim")
    limit: float | None = key("99 % quantile of the ratio for white noise")
    legs: int = key("number of legs")
    sentence: str = key("meaning; empty for a sound claim")


class DecidingLegJson(ResultTable):
    """What to fly for an answer."""

    sentence: str = key("in words")
    duration_s: float = key("duration")


class ToleranceJson(ResultTable):
    """Answer to --tolerance-deg."""

    tolerance_deg: float = key("asked tolerance of the heading error")
    answer: str = key("yes, no or undecidable, at 95 %")
    probability: float | None = key("probability that the error is below the tolerance")
    causes: dict[str, float | None] | None = key("heading error by cause, degrees; null where not known")
    next_leg: DecidingLegJson | None = key("what to fly where undecidable")


class PairJson(ResultTable):
    """Two models compared on legs that neither had seen."""

    model: str = key("the richer model")
    parameters: int = key("number of parameters of the richer model")
    against: str = key("the simpler model")
    verdict: str = key("worth_it, as_well, worse or cannot_tell")
    better_nT: float | None = key("by how much the richer model predicts better")
    low_nT: float | None = key("lower end of the 95 % interval")
    high_nT: float | None = key("upper end")
    rms_nT: float | None = key("typical error of the richer model")
    against_rms_nT: float | None = key("typical error of the simpler model")
    legs_counted: float | None = key("number of independent legs, as their scatter tells")
    doubt: str = key("reason against a verdict; empty for none")
    sentence: str = key("in words")


class WorthJson(ResultTable):
    """Whether richer models predict unseen legs better, of a sensor."""

    sensor: str = key("sensor")
    knowledge: str = key("what is known of the field: strength or vector")
    legs: int = key("number of legs")
    legs_by: str = key("how the recording was cut into legs")
    keep: str | None = key("recommended model")
    comparisons: list[PairJson] = key("pairs of models, simplest first")


class InUnitFitJson(ResultTable):
    """Offset and matrix in another unit."""

    offset: Three = key("in `unit`")
    matrix: ThreeByThree = key("from `unit` to `field_unit`")


class InUnitJson(ResultTable):
    """Calibrations in the unit of --unit-out: calibration_in_UNIT.json."""

    unit: str = key("unit of the measurement and the offset")
    field_unit: str = key("unit of the calibrated field")
    nT: Three = key("nT of one unit, by axis")
    calibrations: dict[str, InUnitFitJson | None] = key("by calibrator; null without an estimate")


class BaseStationJson(ResultTable):
    """The day's change that was taken off, of --base."""

    station: str = key("the station")
    low_nT: float = key("least change in the log's time")
    high_nT: float = key("largest change")
    by: str = key("vector, or strength where the attitude is not known")


class KnownFigureJson(ResultTable):
    """A figure of another program."""

    program: str = key("program")
    name: str = key("name of the figure there")
    value: float | None = key("value on the log; null where the log does not give it")
    unit: str = key("unit")
    limit: float | None = key("limit of the program; null for none")
    at_most: bool = key("whether the limit is an upper one")
    note: str = key("why there is no value")
    passes: bool | None = key("whether the program would accept the calibration")


class CalibrateJson(ResultTable):
    """Calibrations of a recording, and how good they are."""

    calibrations: dict[str, AssessedCalibrationJson] = key("by calibrator")
    screening: list[FaultJson] = key("faults of the sensor")
    claims: dict[str, ClaimJson] = key("claimed standard deviations, by calibrator")
    verdict: str = key("the answer in a sentence")
    recommended: str | None = key("calibrator to use")
    use: str | None = key("what of it to use: nothing, offset, or offset and matrix")
    quality: str | None = key("good, fair or bad")
    trust: str = key("high, medium or low")
    doubts: list[str] = key("reasons against trust")
    tolerance: ToleranceJson | None = key("answer to --tolerance-deg")
    worth: list[WorthJson] | None = where_told("with --worth: a sensor each")
    in_unit: InUnitJson | None = where_told("with --unit-out")
    base: BaseStationJson | None = where_told("with --base")
    known_figures: dict[str, list[KnownFigureJson]] | None = where_told("with --others: by calibrator")


class CalibrationsJson(RootModel[dict[str, CalibrationJson]]):
    """calibration.json of `magbench calibrate`: calibrations by name; each alone is of kind `calibration`."""


class StrengthChangeJson(ResultTable):
    """Strength before and after a correction, each a pair."""

    mean_nT: list[float | None] = key("mean over the samples", min_length=2, max_length=2)
    std_nT: list[float | None] = key("standard deviation over the samples", min_length=2, max_length=2)


class ApplyJson(ResultTable):
    """What `apply` has corrected."""

    calibrator: str = key("which calibration was used")
    samples: int = key("corrected samples")
    corrected: str = key("corrected columns")
    warning: str = key("doubts about the calibration; empty for none")
    strength: dict[str, StrengthChangeJson] = key("before and after, by calibration; of an array NAME@sensor")
    answer: str = key("whether the strength varies less, in words")
    out: str = key("the corrected recording")
    page: str | None = where_told("page beside the corrected recording")


class PartChangeJson(ResultTable):
    """A part of a calibration, now against then."""

    what: str = key("offset, scale, soft iron, motor currents or all together")
    value: list[float | None] = key("change")
    low: list[float | None] = key("lower end of the 95 % interval")
    high: list[float | None] = key("upper end")
    std: list[float | None] = key("standard deviation")
    unit: str = key("unit of the change")
    heading_error_deg: float | None = key("largest heading error of the change on a level survey")
    any_attitude_deg: float | None = key("largest turn of the field of the change, in any attitude")
    chance: float | None = key("probability of such a change by noise alone")
    significant: bool = key("whether noise alone is excluded")


class RecheckJson(ResultTable):
    """Whether an old calibration still holds."""

    old: str = key("the old calibration")
    verdict: str = key("valid, changed or cannot tell")
    sentence: str = key("in words")
    tolerance_deg: float = key("heading error from which on a change matters")
    heading_error_deg: IntervalJson = key("heading error of the old calibration")
    excluded_deg: float | None = key("heading error that is excluded at 99 %")
    offset_change_found_nT: float | None = where_told("offset change that would have shown, 95 %")
    offset_change_found_counts: float | None = where_told("the same for a calibration in counts")
    changes: list[PartChangeJson] = key("parts that changed")
    parts: list[PartChangeJson] = key("every part that the log determines")
    knowledge: str = key("what is known of the field")
    reason: str = key("why nothing can be told; empty otherwise")
    notes: list[str] = key("how the old calibration was read")
