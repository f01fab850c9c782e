"""JSON of `magbench bound` and `magbench plan`."""

from __future__ import annotations

from pydantic import ConfigDict

from reports.schemas.base import ResultTable, Three, ThreeOrNull, key, where_told


class GoalTable(ResultTable):
    """A table with the value of the goal, or of scores, under their own names beside the declared keys."""

    model_config = ConfigDict(extra="allow")
    __pydantic_extra__: dict[str, float | None]


class UnobservableJson(ResultTable):
    """A direction of the parameters that the motion hardly determines."""

    what: str = key("the parameters that trade against each other")
    why: str = key("cause")
    remedy: str = key("what to fly")


class TiltLimitJson(GoalTable):
    """The least error of any motion within tilts, under the goal's name with its unit."""

    roll_deg: float = key("largest roll, either way")
    pitch_deg: float = key("largest pitch, either way")
    duality_gap: float = key("relative distance to a proven lower limit")


class BoundJson(ResultTable):
    """Cramer-Rao bound: the least standard deviations of any unbiased method; null where not observable."""

    knowledge: str = key("what the method knows: norm, norm+gyro, norm+gyro+accel, vector or vector+eddy")
    noise_std_nT: float = key("white noise of each axis")
    samples: int = key("number of samples")
    offset_std_nT: ThreeOrNull = key("least standard deviation of the offset, by axis")
    offset_rms_nT: float | None = key("their root of the sum of squares")
    matrix_std: list[ThreeOrNull] = key("least standard deviation of the matrix, row by row")
    eddy_std_s: list[ThreeOrNull] | None = where_told("of the eddy currents; with vector+eddy")
    flicker_nT_sqrt_hz: float | None = where_told("flicker noise counted in; with --coloured")
    walk_nT_sqrt_s: float | None = where_told("random walk counted in; with --coloured")
    scores: dict[str, float | None] = key("bound of each score, unit in the name")
    observable: bool = key("whether every parameter is determined")
    unobservable: list[UnobservableJson] = key("directions that are not, weakest first")
    limit: TiltLimitJson | None = where_told("the best of any motion; with --tilt-limits")


class BoundAtJson(BoundJson):
    """The bound at one value."""

    value: float | str = key("value of the swept key")


class SweptBoundsJson(ResultTable):
    """Bounds over a key of the scenario."""

    key_: str = key("the swept key of the scenario", alias="key")
    points: list[BoundAtJson] = key("a bound each value")


class WhatIfJson(ResultTable):
    """Bounds of `bound --what-if`."""

    what_if: SweptBoundsJson = key("key and bounds")
    out: str = key("directory of page and numbers")


class AttitudeJson(ResultTable):
    """An attitude to hold."""

    attitude: str = key("in words, as a pilot is told")
    yaw_deg: float = key("yaw")
    pitch_deg: float = key("pitch, nose down positive")
    roll_deg: float = key("roll, right side down positive")
    begins_s: float = key("begin")
    lasts_s: float = key("duration")


class PredictedJson(GoalTable):
    """Predicted error under the goal's name, and the bound of each score under its own."""

    time_s: float = key("duration of the manoeuvre")
    met: bool | None = key("whether the target of --target is met; null without one")


class StayingJson(GoalTable):
    """The limit of a vehicle that tilts only by thrust and stays in place, under the goal's name."""

    ratio: float | None = key("predicted error over the limit")
    duality_gap: float = key("relative distance to a proven lower limit")


class PlanLimitJson(GoalTable):
    """The least error of any motion within the tilts in the same time, under the goal's name."""

    ratio: float | None = key("predicted error over the limit")
    duality_gap: float = key("relative distance to a proven lower limit")
    staying: StayingJson | None = key("limit of vehicles that stay in place; null for others")
    roll_deg: float = key("largest roll allowed")
    pitch_deg: float = key("largest pitch allowed")
    flown_roll_deg: float = key("largest roll of the plan")
    flown_pitch_deg: float = key("largest pitch of the plan")


class ConfirmedJson(GoalTable):
    """Rms error of trials of the plan, under the goal's name."""

    calibrator: str = key("calibrator of the trials")
    trials: int = key("number of trials")
    failures: int = key("trials without an estimate")


class PlanJson(ResultTable):
    """plan.json: the best manoeuvre of a vehicle in a time."""

    scenario: str = key("file with the manoeuvre, for `magbench run`")
    field_enu_nT: Three = key("the field for which the plan holds: east, north, up")
    predicted: PredictedJson = key("what the manoeuvre gives")
    limit: PlanLimitJson = key("what any manoeuvre could give")
    legs: list[AttitudeJson] = key("the attitudes in order")
    confirmed: ConfirmedJson | None = where_told("what trials of the plan gave; without --trials 0")
    out: str | None = where_told("directory of the files (with --json)")


class LegGainJson(ResultTable):
    """A leg with the error before and after, in the goal's unit."""

    model_config = ConfigDict(extra="allow")
    __pydantic_extra__: dict[str, float | None]
    lasts_s: float = key("duration of the leg")
    attitudes: list[AttitudeJson] = key("the attitudes in order")


class PredictedAfterJson(GoalTable):
    """Error of recording and legs together, under the goal's name."""

    before: float | None = key("error of the recording alone; null where not determined")


class LimitAfterJson(GoalTable):
    """The least error of any motion in the same time, under the goal's name."""

    duality_gap: float = key("relative distance to a proven lower limit")


class PlanAfterJson(ResultTable):
    """plan.json of `plan --after`: the legs to fly after a recording."""

    scenario: str | None = key("file with the legs; null where none pays")
    field_enu_nT: Three = key("the field for which the plan holds: east, north, up")
    predicted: PredictedAfterJson = key("error with the legs")
    limit: LimitAfterJson | None = key("limit of any motion")
    legs: list[LegGainJson] = key("legs that pay, in order; before_UNIT, after_UNIT and gain_UNIT each")
    no_longer_pays: LegGainJson | None = key("the first leg that does not pay")
    out: str | None = where_told("directory of the files (with --json)")
