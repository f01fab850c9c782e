"""Files of `run`: simulate a scenario, calibrate, score against the truth, write page and recording."""

from __future__ import annotations

import json
from collections.abc import Callable, Sequence
from dataclasses import asdict, replace
from pathlib import Path
from typing import Any

import numpy as np

import calib
from calib import Reference
from recordings import Recording, Truth, read_run
from recordings.files import locked_directory, write_text
from reports.pages.outcome import outcome_page
from reports.text.outcome import compare_command
from reports.viewer import DRAWN, FULL, Detail, write_recording
from scenarios.errors import InputError
from scenarios.plain import json_ready
from sim import effects as effect_table
from sim.dataset_writer import DatasetPlan, write_runs
from sim.effects.base import Effect
from sim.scenario import Scenario
from validation.bound.files import true_experiment
from validation.bound.ratio import LeastErrors, bound_ratio, knowledge_of, least_errors
from validation.bound.sensor_noise import stated_colour, stated_noise_nT
from validation.calibrating.calibration_file import write_calibrations
from validation.calibrating.calibrator_entry import CalibratorEntry
from validation.calibrating.selection import calibrators_of_scenario
from validation.scoring.definitions import SCORE_DEFINITIONS
from validation.scoring.evaluation import UNCORRECTED, score_calibrators
from validation.scoring.outcome import Outcome
from validation.scoring.scores import Score

Progress = Callable[[float, int], object]
"""Called with (stages done, stages in all); a fraction within simulation and calibration."""
STAGES = 4


def run_scenario(
    scenario: Scenario,
    out: Path,
    *,
    seed: int | None = None,
    chosen: Sequence[CalibratorEntry] | None = None,
    full: bool = False,
    asked: tuple[str, ...] = ("",),
    progress: Progress = lambda done, total: None,
    warn: Callable[[str], object] = lambda text: None,
) -> Outcome:
    """Write the dataset, scores.json, calibration.json, report.html and recording.rrd into `out`.

    chosen : calibrators, by default the scenario's. full : the recording keeps every sample. asked : see `Outcome`.

    An existing dataset of the same scenario and seed is reused. Raises InputError for a bad scenario, an unknown
    calibrator, an `out` with a different dataset or a second writing process, and where the system refuses to write.

    >>> from sim.scenario import load
    >>> outcome = run_scenario(load("tumble", ["phases.0.duration_s=60"]), Path("out"))
    >>> sorted(file.name for file in Path("out").iterdir())[:3]
    ['calibration.json', 'dataset.json', 'recording.rrd']
    """
    chosen = chosen or calibrators_of_scenario(scenario.calibrators)
    with locked_directory(out):
        outcome = replace(simulate_and_score(scenario, out, seed, chosen, progress, warn), asked=asked)
        _write(outcome, out, FULL if full else DRAWN, progress)
    return outcome


def simulate_and_score(
    scenario: Scenario,
    out: Path,
    seed: int | None,
    chosen: Sequence[CalibratorEntry] | None = None,
    progress: Progress = lambda done, total: None,
    warn: Callable[[str], object] = lambda text: None,
) -> Outcome:
    """Write the dataset into `out`, fit the calibrators and score the calibrations: the first two stages."""
    dataset = DatasetPlan(scenario, out, 1, scenario.seed if seed is None else seed)
    written = write_runs(dataset, 1, lambda done, total: progress(done / total, STAGES), warn)
    recording, truth = read_run(out)
    simulated = scenario.model_copy(update={"seed": dataset.seed})
    outcome = calibrate_and_score(simulated, recording, truth, lambda part: progress(1 + part, STAGES), chosen)
    return replace(outcome, tracking=written.files[0].tracking)


def _write(outcome: Outcome, out: Path, detail: Detail, progress: Progress) -> None:
    """Write calibrations, scores, page and recording: the last two stages."""
    write_calibrations(outcome.calibrations, out)
    write_text(out / "scores.json", json.dumps(summary(outcome), indent=1, allow_nan=False) + "\n")
    progress(2, STAGES)
    write_text(out / "report.html", outcome_page(outcome))
    progress(3, STAGES)
    write_recording(outcome, out / "recording.rrd", detail)
    progress(4, STAGES)


def calibrate_and_score(
    scenario: Scenario,
    recording: Recording,
    truth: Truth,
    progress: Callable[[float], object] = lambda part: None,
    chosen: Sequence[CalibratorEntry] | None = None,
    rng: Callable[[], np.random.Generator] = lambda: np.random.default_rng(0),
) -> Outcome:
    """Fit the chosen calibrators, by default the scenario's, to a recording, and score against the truth.

    rng : makes the generator for each fit.
    """
    chosen = chosen or calibrators_of_scenario(scenario.calibrators)
    east, north, up = truth.parameters["field_enu_nT"]
    reference = Reference(float(np.linalg.norm([east, north, up])), (east, north, up))
    found = score_calibrators(recording, _effects(truth), reference, chosen, rng, progress)
    fits = {key: one.fit for key, one in found.items() if key.split("@")[0] != UNCORRECTED}
    usable = {key: fit for key, fit in fits.items() if fit.calibration.status.kind != "not_applicable"}
    return Outcome(
        scenario,
        recording,
        truth,
        calibrations={key: fit.calibration for key, fit in fits.items()},
        scores={key: one.scores for key, one in found.items()},
        corrected={key: fit.calibration.apply(fit.recording) for key, fit in usable.items()},
        needs={one.name: one.needs for one in chosen},
    )


def summary(outcome: Outcome) -> dict[str, Any]:
    """Return scores and calibrations as plain values, the JSON of `run`; a non-finite number is null."""
    found: dict[str, Any] = json_ready(
        {
            "scenario": outcome.scenario.name,
            "answer": outcome.answer().plain() | {"compare": compare_command(outcome)},
            "ranking": outcome.ranking()[0],
            "tracking": outcome.tracking and asdict(outcome.tracking),
            "scores": _rows(outcome),
            "calibrations": {key: calib.to_dict(c) for key, c in outcome.calibrations.items()},
        }
    )
    return found


def _rows(outcome: Outcome) -> dict[str, list[dict[str, Any]]]:
    """Return every score as plain values, with the ratio to the bound for the calibrator's knowledge where known."""
    knowledge_by_fit = {
        key: knowledge_of(
            key,
            outcome.needs.get(key.split("@")[0], ()),
            attitude_free=any(one.rotation_removed for one in outcome.scores.get(key, ())),
            eddy=fit.eddy_s is not None,
        )
        for key, fit in outcome.calibrations.items()
    }
    least = _least(outcome, {knowledge for knowledge in knowledge_by_fit.values() if knowledge})
    return {
        key: [
            _row(one, least.get((knowledge_by_fit.get(key) or "", SCORE_DEFINITIONS[one.name].column), np.nan))
            for one in scores
        ]
        for key, scores in outcome.scores.items()
    }


def _row(one: Score, least: float) -> dict[str, Any]:
    plain = {key: value for key, value in asdict(one).items() if key != "name"}
    return {"score": one.name, **plain, "bound_ratio": bound_ratio(np.array([one.value]), np.array([least]))}


def _least(outcome: Outcome, knowledges: set[str]) -> LeastErrors:
    """Return the bound on the scores of a run; empty for arrays, without noise or without known chain."""
    if outcome.sensors > 1 or not knowledges or "effect_order" not in outcome.truth.parameters:
        return {}
    truth, (effects, *_) = outcome.truth, _effects(outcome.truth)
    enu_nT, name = np.array(truth.parameters["field_enu_nT"]), outcome.scenario.name
    try:
        known = true_experiment(outcome.recording, truth, effects, enu_nT, name, stated_noise_nT(effects))
        return least_errors(replace(known, colour=stated_colour(effects)), knowledges)
    except InputError:
        return {}


def _effects(truth: Truth) -> list[tuple[Effect, ...]]:
    """Return the true effects of each sensor in the order of the chain."""
    order = truth.parameters["effect_order"]
    return [
        effect_table.build(tables, [name for name in order if name in tables], "run")
        for tables in truth.parameters["effects"]
    ]
