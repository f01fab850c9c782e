"""Files of a comparison: trials as they are computed, then tables, answer, page, and recordings of three trials."""

from __future__ import annotations

import json
from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np

from recordings.files import locked_directory, remove_leftovers, write_text
from reports.outputs.kept_recordings import RECORDINGS, KeptRecordings
from reports.outputs.run import calibrate_and_score
from reports.pages.comparison import Comparison, comparison_page, point_title
from reports.viewer import write_recording
from scenarios.arrays import Array
from scenarios.errors import InputError
from scenarios.plain import json_ready
from scenarios.seeds import stream
from sim.memory_run import run_in_memory
from sim.simulation import plan
from validation.bound.ratio import bound_ratio, knowledge_of
from validation.comparison.design import Design
from validation.comparison.engine import Engine, new_trials
from validation.comparison.journal import Journal
from validation.comparison.kept_bounds import BOUNDS, KeptBounds
from validation.comparison.ranking import Ranking, overall_sentence, rank_calibrators
from validation.comparison.score_statistics import ScoreStatistic, score_statistics
from validation.comparison.statistics import LEVEL, width_ratio
from validation.comparison.stopping import StoppingRule, interim_looks
from validation.comparison.trial import CALIBRATORS_STREAM
from validation.comparison.trial_table import TrialTable
from validation.scoring.definitions import ScoreDefinition, score_definition
from validation.scoring.outcome import RANKED_BY, Outcome
from validation.text import listed

Progress = Callable[[float, int], object]
"""Called with (pieces done, pieces in all): trials and recordings, from 0."""
SHOWN = ("best", "median", "worst")
"""The trials of the best calibrator that are recorded."""
ANSWER, REPORT = "comparison.json", "report.html"


@dataclass(frozen=True)
class ComparisonQuestion:
    """Question of a comparison: the score that ranks the calibrators, the reference calibrator, and the stopping rule.

    reference: calibrator in the denominator of ratios, by default the best at the first point; until: None for a fixed
    number of trials.
    """

    score: ScoreDefinition
    reference: str | None = None
    until: StoppingRule | None = None


def comparison_question(
    rank_by: str | None = None, reference: str | None = None, until: str | None = None
) -> ComparisonQuestion:
    """Parse the options of `compare`; raises InputError for an unknown score or stopping rule."""
    return ComparisonQuestion(
        score_definition(rank_by or RANKED_BY, "--rank-by"),
        reference,
        None if until is None else StoppingRule.parsed(until),
    )


def compare(
    design: Design,
    trials: int,
    out: Path,
    engine: Engine,
    progress: Progress = lambda done, total: None,
    question: ComparisonQuestion | None = None,
    warn: Callable[[str], object] = lambda text: None,
) -> Comparison:
    """Compute trials at every point, write all files of the comparison into `out`, and return the content of the page.

    trials: number of trials, or the largest number with a stopping rule. Trials in `out` are kept: a killed comparison
    resumes, and a larger number extends a finished comparison. The bytes of trials.parquet depend on design and number
    of trials alone.
    Raises InputError where `out` holds a different comparison or a second process writes to `out`, where a trial cannot
    be simulated, and for a reference that does not take part.
    """
    question = question or comparison_question()
    _check_reference(design, question.reference)
    with locked_directory(out):
        remove_leftovers(out)
        journal = Journal.open(out, design.identity(), warn=warn)
        with journal.left_where_begun():
            table = _computed(design, trials, journal, engine, progress, question)
        table.write(out)
        found = _answered(design, table, question, out)
        write_text(out / ANSWER, json.dumps(summary(found, design.seed), indent=1, allow_nan=False) + "\n")
        write_text(out / REPORT, comparison_page(found, design.seed))
        total = _pieces(design, trials)
        _record(KeptRecordings(out, design), found, lambda done: progress(total - len(SHOWN) + done, total))
    return found


def _check_reference(design: Design, reference: str | None) -> None:
    names = [one.name for one in design.candidates]
    if reference is not None and reference not in names:
        what = f"calibrator {reference!r} does not take part"
        raise InputError(what, where="--reference", do=f"choose among {', '.join(names)}")


def _computed(
    design: Design, most: int, journal: Journal, engine: Engine, progress: Progress, question: ComparisonQuestion
) -> TrialTable:
    """Compute trials up to the stopping rule or `most`; the rule is checked after fixed numbers of trials."""
    done, first = 0, 0
    progress(done, _pieces(design, most))
    for number in [most] if question.until is None else interim_looks(most):
        kept = sum(first <= run < number for _, run in journal.there)
        done += kept
        if kept:
            progress(done, _pieces(design, most))
        for _ in new_trials(design, range(first, number), engine, journal):
            done += 1
            progress(done, _pieces(design, most))
        table = TrialTable.of_columns(design, journal.columns(number))
        if question.until is not None and question.until.reached(_columns(table, question.until)):
            break
        first = number
    return table


def _pieces(design: Design, most: int) -> int:
    return most * len(design.points) + len(SHOWN)


def _columns(table: TrialTable, until: StoppingRule) -> list[Any]:
    return [table.values(until.score, name, point) for point in table.points for name in table.candidates]


def _answered(design: Design, table: TrialTable, question: ComparisonQuestion, out: Path) -> Comparison:
    answers = tuple(rank_calibrators(table, question.score, point) for point in table.points)
    titles = [point_title(values) for values in table.points.values()]
    return Comparison(
        title=design.points[0].scenario.name,
        table=table,
        answers=answers,
        sentence=overall_sentence(answers, titles),
        reference=question.reference or answers[0].best.calibrator.split("@")[0],
        looked_at=_looked_at(table, answers[0]),
        least=_least(design, table, out),
    )


def _least(design: Design, table: TrialTable, out: Path) -> dict[tuple[int, str, str], Array]:
    """Return the bound (n,) on each score in every run, by point, calibrator and column; NaN where unknown."""
    knowledge_by_name = {
        one.name: knowledge_of(one.name, one.needs, attitude_free=one.attitude_free, eddy=one.eddy)
        for one in design.candidates
    }
    kept = KeptBounds(out / BOUNDS, design, frozenset(filter(None, knowledge_by_name.values())))
    least: dict[tuple[int, str, str], Array] = {}
    for number in range(len(design.points)):
        found = kept.of(number, table.runs(number).tolist())
        keys = {key for one in found for key in one}
        columns = {key: np.array([one.get(key, np.nan) for one in found]) for key in keys}
        least |= {
            (number, name, column): columns[of, column]
            for name, knowledge in knowledge_by_name.items()
            for of, column in keys
            if of == knowledge
        }
    return least


def summary(comparison: Comparison, seed: int) -> dict[str, Any]:
    """Return answer and statistics as plain values, the JSON of `compare`; a non-finite number is null."""
    table = comparison.table
    first = comparison.answers[0]
    result: dict[str, Any] = json_ready(
        {
            "scenario": comparison.title,
            "seed": seed,
            "trials": first.trials,
            "answer": comparison.sentence,
            "ranked_by": first.score.name,
            "ranking": [[one.calibrator for one in ranking.calibrators] for ranking in comparison.answers],
            "intervals": {"level": LEVEL, "hold": first.cost, "width_ratio": width_ratio(first.trials)},
            "reference": comparison.reference,
            "calibrators": table.calibrators,
            "scores": table.scores,
            "points": [{"point": point, **values} for point, values in table.points.items()],
            "table": [_row(comparison, one) for one in score_statistics(table, comparison.reference)],
            "differences": [
                {"point": point, **vars(one)}
                for point, ranking in enumerate(comparison.answers)
                for one in ranking.differences
            ],
        }
    )
    return result


def _row(comparison: Comparison, one: ScoreStatistic) -> dict[str, Any]:
    table, ratio = comparison.table, None if one.ratio is None else vars(one.ratio)
    values = table.values(one.score.column, one.calibrator, one.point)
    least = comparison.least.get((one.point, one.calibrator, one.score.column), np.full(len(values), np.nan))
    return {
        "point": one.point,
        **table.points[one.point],
        "calibrator": one.calibrator,
        "score": one.score.name,
        "unit": one.score.unit,
        "median": one.found.value,
        "low": one.found.low,
        "high": one.found.high,
        "failures": one.failures,
        "reason": one.reason,
        "trials": one.trials,
        "bound_ratio": bound_ratio(values, least),
        "reference_ratio": ratio,
    }


def _shown_runs(table: TrialTable, first: Ranking) -> dict[str, int]:
    """Return the runs of the first point with the least, the median and the largest score of the best calibrator."""
    values = table.values(first.score.column, first.best.calibrator)
    order = [int(k) for k in np.argsort(values, kind="stable") if np.isfinite(values[k])]
    runs = table.runs()
    if not order:
        return {}
    return {name: int(runs[order[k]]) for name, k in zip(SHOWN, (0, len(order) // 2, -1), strict=True)}


def _looked_at(table: TrialTable, first: Ranking) -> str:
    runs = _shown_runs(table, first)
    if not runs:
        return "No trial gave an estimate that could be shown."
    which = listed([f"the {name} is run {run} (`{RECORDINGS}/{name}.rrd`)" for name, run in runs.items()])
    return f"Of {first.best.calibrator}'s trials at the first point {which}: open them with `magbench show`."


def _record(kept: KeptRecordings, comparison: Comparison, progress: Callable[[int], object]) -> None:
    """Write recordings of the best calibrator's best, median and worst trial at the first point; fit each run once.

    Recordings that are there already stay. progress: called with the number of finished recordings, from 0.
    """
    (kept.out / RECORDINGS).mkdir(exist_ok=True)
    shown = _shown_runs(comparison.table, comparison.answers[0])
    if not kept.show(shown):
        done = 0
        for run in dict.fromkeys(shown.values()):
            progress(done)
            outcome = _outcome(kept.design, run)
            for name in (name for name in shown if shown[name] == run):
                write_recording(outcome, kept.file(name))
                done += 1
        kept.keep(shown)
    progress(len(SHOWN))


def _outcome(design: Design, run: int) -> Outcome:
    """Simulate, calibrate and score a trial of the first point again, for its recording."""
    scenario = design.points[0].scenario
    recording, truth = run_in_memory(plan(scenario, run, design.seed))
    rng = partial(stream, design.seed, run, CALIBRATORS_STREAM)
    return calibrate_and_score(scenario, recording, truth, chosen=design.candidates, rng=rng)
