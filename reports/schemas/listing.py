"""JSON of `magbench read`, `inspect`, `list`, `show` and `reproduce`."""

from __future__ import annotations

from typing import Any

from reports.schemas.base import ResultTable, Three, ThreeByThree, key
from reports.schemas.dataset import ColumnJson


class AppliedJson(ResultTable):
    """A calibration that was in force while the log was written."""

    autopilot: str = key("autopilot")
    compass: int = key("number of the compass")
    offset_nT: Three = key("offset")
    matrix: ThreeByThree = key("matrix")
    parameters: dict[str, float] = key("the autopilot's own parameters")
    undone: bool = key("whether the measurement was restored to that before the calibration")


class ReadJson(ResultTable):
    """What was found in a log, and what was done."""

    log: str = key("the log")
    format: str = key("format")
    samples: int = key("samples")
    length_s: float = key("length")
    rate_hz: float = key("rate of the magnetometer")
    unit: str = key("unit of the log's magnetometer; the columns are in nT")
    frame: str = key("frame of the log's vectors; the columns are forward, left, up")
    magnetometer: str = key("the magnetometer that was read")
    place: list[float] | None = key("latitude, longitude in degrees and altitude in m; null where not told")
    date: str | None = key("date; null where not told")
    applied: AppliedJson | None = key("calibration in force; null for none")
    magnetometers: list[str] = key("every magnetometer in the log")
    field_enu_nT: Three | None = key("the Earth's field at place and date: east, north, up; null where not known")
    columns: list[ColumnJson] = key("columns of the recording")
    notes: list[str] = key("how names, units and rows were read")
    out: str | None = key("the recording of -o; null without")


class FindingJson(ResultTable):
    """A finding on a recording."""

    section: str = key("section: file, timing, values, motion, noise, ...")
    name: str = key("name in the section")
    value: Any = key("number, list, table or text")
    unit: str = key("unit")
    text: str = key("in words")
    level: str = key("ok, note or warning")
    sensor: int | None = key("sensor of an array, from 1; null for the recording")


class InspectJson(ResultTable):
    """inspect.json: findings on a recording."""

    file: str = key("the recording")
    samples: int = key("samples")
    sensors: int = key("magnetometers")
    warnings: list[str] = key("what to mend or to know first")
    findings: list[FindingJson] = key("every finding")


class ItemJson(ResultTable):
    """A name with a line about it."""

    name: str = key("name")
    summary: str = key("what it is")


class ListJson(ResultTable):
    """Names of `list KIND`, and of `schema` without a kind."""

    items: list[ItemJson] = key("a name each")


class ShowJson(ResultTable):
    """What `show` has opened."""

    file: str = key("the recording.rrd")


class PaperRowJson(ResultTable):
    """A printed figure or claim beside the bench's."""

    what: str = key("figure or claim")
    paper: str = key("what the paper prints")
    ours: str = key("what the bench finds, with its spread")
    holds: bool = key("whether the paper is confirmed")
    verdict: str = key("in one word or two")
    tolerance: str = key("difference up to which a figure is confirmed")
    note: str = key("why they differ, or cannot be compared")


class PaperJson(ResultTable):
    """A paper."""

    key_: str = key("key in REFERENCES.md", alias="key")
    title: str = key("title of the repetition")
    seeds: int = key("independent repetitions")
    rows: list[PaperRowJson] = key("figures and claims")


class ReproduceJson(ResultTable):
    """reproduction.json: papers' figures beside the bench's."""

    papers: list[PaperJson] = key("a paper each")
