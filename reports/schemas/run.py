"""JSON of `magbench run`: scores.json, and `--json`."""

from __future__ import annotations

from reports.schemas.base import CalibrationJson, ResultTable, TrackingJson, key, where_told


class FailedFitJson(ResultTable):
    """A calibrator without a usable estimate."""

    calibrator: str = key("name")
    status: str = key("not_converged, unobservable or not_applicable")
    reason: str = key("cause and remedy")


class RunAnswerJson(ResultTable):
    """Which calibrator to use, and what to expect."""

    use: str | None = key("recommended calibrator; null where none is usable")
    sentence: str = key("the recommendation in words, with expected errors")
    failed: list[FailedFitJson] = key("calibrators without a usable estimate, best first")
    closer: list[str] = key("a sentence for each failed calibrator that is nearer to the truth all the same")
    compare: str = key("the command that compares the calibrators over many trials")


class ScoreJson(ResultTable):
    """A score of a calibration against the truth."""

    score: str = key("name, see docs/scores.md")
    value: float | None = key("value; null where there is none")
    unit: str = key("unit of the value")
    in_sample: bool = key("whether the fit's own data were scored, which never ranks")
    rotation_removed: bool = key("whether the rotation that the field strength leaves open was taken off first")
    bound_ratio: float | None = key("value over the least that any method with the same knowledge can reach")


class RunJson(ResultTable):
    """Scores and calibrations of a simulated run."""

    scenario: str = key("name of the scenario")
    answer: RunAnswerJson = key("recommendation")
    ranking: list[str] = key("calibrators, best first")
    tracking: TrackingJson | None = key("how well the path was followed; null for a vehicle that follows none")
    scores: dict[str, list[ScoreJson]] = key("by calibrator; `uncorrected`: the raw measurement")
    calibrations: dict[str, CalibrationJson] = key("by calibrator")
    out: str | None = where_told("directory of the files (with --json)")
    failures: list[str] | None = where_told("conditions of --fail-if that hold, calibrators not applicable (--json)")
