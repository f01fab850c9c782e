"""JSON of `magbench compare` and `magbench gate`."""

from __future__ import annotations

from pydantic import ConfigDict

from reports.schemas.base import ResultTable, key, where_told

Overridden = float | str | bool | None


class PointJson(ResultTable):
    """A point of the sweep; every swept key stands beside the declared ones with its value."""

    model_config = ConfigDict(extra="allow")
    __pydantic_extra__: dict[str, Overridden]
    point: int = key("number of the point, from 0")


class ConfidenceJson(ResultTable):
    """Intervals at any number of looks."""

    level: float = key("probability with which all intervals hold")
    hold: str = key("what the intervals hold for, and their cost")
    width_ratio: float | None = key("width over that of an interval for a single look")


class ReferenceRatioJson(ResultTable):
    """Score over the reference's score in the same trial."""

    value: float | None = key("median")
    low: float | None = key("lower end of the interval")
    high: float | None = key("upper end")


class StatisticJson(PointJson):
    """A score of a calibrator at a point, over the trials."""

    calibrator: str = key("calibrator")
    score: str = key("score, see docs/scores.md")
    unit: str = key("unit")
    median: float | None = key("median over the trials")
    low: float | None = key("lower end of its interval")
    high: float | None = key("upper end")
    failures: int = key("trials without an estimate")
    reason: str = key("most frequent reason of a failure")
    trials: int = key("number of trials")
    bound_ratio: float | None = key("rms over the Cramer-Rao bound")
    reference_ratio: ReferenceRatioJson | None = key("against --reference; null without one")


class PairedDifferenceJson(ResultTable):
    """Two calibrators over equal trials."""

    point: int = key("number of the point")
    one: str = key("calibrator")
    other: str = key("calibrator")
    better: int = key("trials in which `one` is better")
    worse: int = key("trials in which `one` is worse")
    equal: int = key("trials in which both are equal")
    p: float = key("sequential sign test, corrected for the number of pairs")


class CompareJson(ResultTable):
    """comparison.json: calibrators over many trials."""

    scenario: str = key("name of the scenario")
    seed: int = key("seed of the trials")
    trials: int = key("trials of each point")
    answer: str = key("the best calibrator, in words")
    ranked_by: str = key("score of the ranking")
    ranking: list[list[str]] = key("calibrators of each point, best first")
    intervals: ConfidenceJson = key("what the intervals mean")
    reference: str | None = key("calibrator of --reference")
    calibrators: list[str] = key("calibrators")
    scores: list[str] = key("scores, unit in the name")
    points: list[PointJson] = key("points of the sweep")
    table: list[StatisticJson] = key("a row for each point, calibrator and score")
    differences: list[PairedDifferenceJson] = key("a row for each pair of calibrators and point")
    out: str | None = where_told("directory of the files (with --json)")


class TrajectoryJson(ResultTable):
    """The evidence of a gate, trial by trial in the order of runs."""

    value: list[float | None] = key("score")
    exceeded: list[bool] = key("whether the limit was exceeded")
    log10_evidence_over: list[float | None] = key("evidence that the limit is exceeded too often")
    log10_evidence_within: list[float | None] = key("evidence that the limit is kept")
    log10_to_fail: float = key("evidence at which the gate fails")
    log10_to_pass: float = key("evidence at which the gate passes")


class GateOutcomeJson(ResultTable):
    """The outcome of a gate."""

    name: str = key("name of the gate")
    verdict: str = key("pass, fail or inconclusive")
    scenario: str = key("scenario")
    calibrator: str = key("calibrator")
    score: str = key("score, unit in the name")
    quantile: float = key("quantile of the score that is held to the limit")
    measured: float | None = key("the quantile over the trials; null where estimates are missing")
    limit: float = key("limit, in `unit`, or as a multiple where limit_of is given")
    unit: str = key("unit of measured and limit")
    limit_of: str | None = key("reference or baseline that the limit multiplies")
    trials: int = key("trials that were looked at")
    exceeded: int = key("trials over the limit")
    without_estimate: int = key("trials without an estimate")
    reason: str = key("most frequent reason of a missing estimate")
    max_trials: int = key("most trials of the gate")
    more_trials: int | None = key("trials that would probably decide; null for a decided gate")
    smallest_seen: float | None = key("smallest score that would have failed, with the power below")
    smallest_seen_factor: float | None = key("the same as a multiple of the limit")
    smallest_seen_exceedance: float | None = key("the same as a share of trials over the limit")
    power: float = key("probability with which a defect of that size fails")
    false_fail_rate: float = key("probability of a failure without a defect")
    trajectory: TrajectoryJson | None = where_told("the evidence trial by trial (in gates.json)")


class GateJson(ResultTable):
    """gates.json: verdicts on a file of gates."""

    verdict: str = key("fail where any gate failed, else inconclusive where any is open, else pass")
    gates: list[GateOutcomeJson] = key("a gate each")
    out: str | None = where_told("directory of the files (with --json)")


class GateBaselineJson(ResultTable):
    """What `gate --write-baseline` has written."""

    scores: int = key("number of scores")
    out: str = key("the baseline")


class GateProposalJson(ResultTable):
    """What `gate --init` has written."""

    gates: list[str] = key("proposed gates")
    left_out: dict[str, str] = key("calibrators without a gate, and why")
    files: list[str] = key("written files")
    out: str = key("the file of gates")
