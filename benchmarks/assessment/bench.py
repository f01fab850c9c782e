"""Assessments of simulated logs against their true heading errors: coverage, wrong answers, area under the curve."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from multiprocessing import get_context

import numpy as np

from benchmarks.assessment.catalogue_logs import CatalogueLog, catalogue_log
from benchmarks.assessment.logs import TUNING, SimulatedLog, log_of
from benchmarks.measure import Row
from calib import get
from scenarios.arrays import Array
from validation.assessment.assessment import assess
from validation.assessment.evidence import CalibrationAssessment
from validation.assessment.heading_error import HeadingError
from validation.assessment.judgement import answer_of
from validation.calibrating.selection import usual_calibrators
from validation.screening.screening import ScreenedRecording, screen

VECTOR = "vector_least_squares"
"""Calibrator of logs with attitude and field vector, assessed by itself: no usual one uses the attitude."""
RATIOS = tuple(np.geomspace(0.25, 4.0, 9))
"""Asked tolerances over the stated heading error: where answers are difficult."""
Log = SimulatedLog | CatalogueLog
BELOW, ABOVE = 0.025, 0.975
LOW, HIGH, WRONG, APART = 0.93, 0.97, 0.05, 0.98
"""Bars: coverage of the interval at least and at most, wrong yes and no, area under the curve of good against bad."""


@dataclass(frozen=True)
class Judged:
    """An assessed calibration of a log. rank : share of the draws below the true error."""

    seed: int
    name: str
    status: str
    recommended: bool
    true_deg: float
    value_deg: float
    rank: float
    inside: bool
    quality: str
    trust: str
    answers: tuple[tuple[str, bool], ...]
    tags: tuple[str, ...]


def judged(seed: int, bank: int = TUNING, only: str | None = None, catalogue: bool = True) -> list[Judged]:
    """Return the assessed calibrations of the log of a seed: by the usual calibrators, and where known by attitude.

    catalogue : a log of the simulator, else one of `logs`.
    """
    log = catalogue_log(seed, bank, only) if catalogue else log_of(seed, only, bank)
    screening = screen(log.recording, log.reference)
    usual = [one.name for one in usual_calibrators(screening.recording, log.reference)]
    vector = log.recording.att_q is not None and log.reference.field_enu_nT is not None
    return [one for names in (usual, [VECTOR] if vector else []) for one in _of_methods(seed, log, screening, names)]


def _of_methods(seed: int, log: Log, screening: ScreenedRecording, names: Sequence[str]) -> Iterator[Judged]:
    """Yield the records of calibrators that are assessed together."""
    fits = {name: screening.judged(get(name).fit(screening.recording, log.reference)) for name in names}
    found = assess(fits, screening, log.reference) if fits else None
    for one in found.calibrations.values() if found else ():
        if one.heading is not None:
            best = VECTOR not in names and found is not None and one.name == found.recommended
            yield _judged(seed, log, one, one.heading, best)


def _judged(seed: int, log: Log, one: CalibrationAssessment, heading: HeadingError, recommended: bool) -> Judged:
    """Return a calibration's record; the truth is for the dip that the assessment says its error is for.

    Of a planar calibration for the log's own dip: its offset holds there alone.
    """
    level = log.level(heading.flight.dip_rad if one.fit.determines_z else None)
    true = level.heading_rms_deg(one.fit, log.recording, turned=heading.turn_included)
    answers = tuple(
        (answer_of(heading, ratio * heading.value)[0], bool(true < ratio * heading.value)) for ratio in RATIOS
    )
    return Judged(
        seed,
        one.name,
        one.fit.status.kind,
        recommended,
        true,
        heading.value,
        float(np.mean(heading.drawn_deg < true)),
        heading.low <= true <= heading.high,
        one.quality,
        one.trust.word,
        answers,
        (log.motion, heading.flight.source, *(log.disturbances or ("sound",)), f"trust {one.trust.word}"),
    )


def all_judged(logs: int, jobs: int = 1, bank: int = TUNING, *, catalogue: bool = True) -> list[Judged]:
    """Return the assessed calibrations of a number of logs; as many processes as jobs."""
    if jobs == 1:
        found = [judged(seed, bank, None, catalogue) for seed in range(logs)]
    else:
        with get_context("spawn").Pool(jobs) as pool:
            found = pool.starmap(judged, [(seed, bank, None, catalogue) for seed in range(logs)], chunksize=4)
    return [one for log in found for one in log]


def table(found: Sequence[Judged]) -> Iterator[str]:
    """Yield the share inside the interval, below and above, by method, and of the recommended by motion and so on."""
    yield f"{'':24} {'logs':>5} {'inside':>7} {'below':>6} {'above':>6}"
    for name, own in _groups(found).items():
        rank = np.array([one.rank for one in own])
        shares = (np.mean([one.inside for one in own]), np.mean(rank < BELOW), np.mean(rank > ABOVE)) if own else ()
        yield f"{name:24} {len(own):5} " + " ".join(f"{share:6.3f}" for share in shares)


def _groups(found: Sequence[Judged]) -> dict[str, list[Judged]]:
    best = [one for one in found if one.recommended]
    usable = [one for one in found if one.status == "ok"]
    groups = {"recommended": best, "not ok": [one for one in found if one.status != "ok"]}
    for one in usable:
        groups.setdefault(f"ok {one.name}", []).append(one)
    for one in best:
        groups.setdefault(f"recommended {one.name}", []).append(one)
    for one in best:
        for tag in one.tags:
            groups.setdefault(tag, []).append(one)
    return groups


def rows_of(found: Sequence[Judged]) -> Iterator[Row]:
    """Yield the figures of the recommended calibrations against their bars."""
    best = [one for one in found if one.recommended]
    inside = _share([one.inside for one in best])
    of = f"of {len(best)} recommended calibrations"
    yield Row("interval holds, at least", inside, LOW, True, of)
    yield Row("interval holds, at most", inside, HIGH, False, of)
    for answer, truth in (("yes", True), ("no", False)):
        wrong = [below != truth for one in best for said, below in one.answers if said == answer]
        yield Row(f"wrong {answer}", _share(wrong), WRONG, False, f"of {len(wrong)} at tolerances near the error")
    good, bad = (_errors(found, word) for word in ("good", "bad"))
    yield Row("good told from bad, area", area(good, bad), APART, True, f"{len(good)} good, {len(bad)} bad")


def _errors(found: Sequence[Judged], quality: str) -> list[float]:
    return [one.true_deg for one in found if one.quality == quality]


def _share(held: Sequence[bool]) -> float | None:
    return float(np.mean(held)) if held else None


def area(low: Sequence[float], high: Sequence[float]) -> float | None:
    """Return the probability that a value of `low` is below one of `high`; None where one is empty."""
    if not low or not high:
        return None
    below: Array = np.array(low)[:, None] - np.array(high)[None]
    return float(np.mean(below < 0) + np.mean(below == 0) / 2)
