"""What the tables of results have in common."""

from __future__ import annotations

from typing import Annotated, Any

from pydantic import BaseModel, Field

Three = Annotated[list[float], Field(min_length=3, max_length=3)]
ThreeOrNull = Annotated[list[float | None], Field(min_length=3, max_length=3)]
"""Of each axis; null where the value is not finite."""
ThreeByThree = Annotated[list[Three], Field(min_length=3, max_length=3)]


def _without_titles(schema: dict[str, Any]) -> None:
    """Take the titles off, which repeat the keys."""
    for value in schema["properties"].values():
        value.pop("title", None)


class ResultTable(BaseModel, extra="forbid", json_schema_extra=_without_titles):
    """A table of a result, whose keys are all declared."""


def key(meaning: str, **rules: Any) -> Any:
    """Return the declaration of a key that is always there."""
    return Field(description=meaning, **rules)


def where_told(meaning: str, **rules: Any) -> Any:
    """Return the declaration of a key that is left out where there is nothing to say."""
    return Field(None, description=meaning, **rules)


class CalibrationJson(ResultTable):
    """A calibration: field = matrix (measured - offset), in the body frame, x forward, y left, z up."""

    name: str = key("calibrator; for a sensor of an array NAME@sensor")
    status: str = key("ok, not_converged, unobservable or not_applicable")
    reason: str = key("why there is no estimate, or why the estimate is doubtful")
    offset_nT: Three | None = key("constant part of the measurement error; null without an estimate")
    matrix: ThreeByThree | None = key("inverse of the measurement error's linear part, row by row")
    eddy_s: ThreeByThree | None = key("eddy currents B of m = S h + b + B dh/dt")
    parameters: dict[str, float] = key("further parameters of the method by name")
    covariance: list[list[float]] | None = key("of the parameters of covariance_names")
    covariance_names: list[str] = key("rows of the covariance, unit in the name")
    history: list[float] = key("the method's own measure of convergence, a value a round")
    wall_s: float = key("time of the fit")
    array_offset_nT: list[Three] | None = key("offset of each sensor of an array")
    array_matrix: list[ThreeByThree] | None = key("matrix of each sensor of an array")
    segments: list[SegmentJson] = key("offset and matrix of each part of the time")
    inputs: list[InputJson] = key("fields of recorded channels, such as motor currents")


class SegmentJson(ResultTable):
    """Offset and matrix from a time on."""

    start_s: float = key("time from which they hold")
    offset_nT: Three = key("offset")
    matrix: ThreeByThree = key("matrix")


class InputJson(ResultTable):
    """Field of a channel: gain times (channel - reference), after the lag."""

    channel: str = key("column of the recording")
    gain_nT: Three = key("field of one unit of the channel")
    reference: float = key("value of the channel at which the field is part of the offset")
    lag_s: float = key("delay of the channel")


class TrackingJson(ResultTable):
    """Distance between true and reference position at equal times."""

    rms_m: float = key("rms over the run")
    max_m: float = key("largest")


class IntervalJson(ResultTable):
    """A value with the ends of its 95 % interval; null where the value is not known."""

    value: float | None = key("estimate")
    low: float | None = key("lower end")
    high: float | None = key("upper end")


CalibrationJson.model_rebuild()
