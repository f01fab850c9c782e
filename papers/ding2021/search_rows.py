"""Rows of [Ding2021]'s claims on the search: population, attitudes, F and CR, genetic algorithm, least squares."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

import numpy as np

from calib.families.gradiometer import GradiometerCalibrator
from papers.base import PaperRow
from papers.ding2021.rows import Results, median_and_range
from papers.ding2021.search_trials import (
    COUNTS,
    EVOLUTION,
    FACTORS,
    GENETIC,
    LARGE,
    SIZES,
    STARTS,
    TIGHT,
    SearchTask,
    StartTask,
    improved_and_classic,
    populations,
)
from papers.judgement import claim, incomparable, number
from scenarios.arrays import Array

ACCEPTED, SOLVED_NT = 0.01, 1e-4


def search_rows(results: Results, seeds: int, few: int, evolved: int) -> Iterable[PaperRow]:
    """Yield the rows on the search for the minimum."""
    yield _stuck(results, few)
    yield _iterations(results, few)
    yield _genetic(results, few)
    yield _factors(results, evolved)
    yield from _count_rows(results, few)
    yield from _least_squares_rows(results, seeds)


def _found(results: Results, method: GradiometerCalibrator, count: int, n: int = 200) -> list[dict[str, Any]]:
    return [results[SearchTask(method, seed, n)] for seed in range(count)]


def _stuck(results: Results, few: int) -> PaperRow:
    stuck = {}
    for size, method in zip(SIZES, populations(), strict=True):
        runs = _found(results, method, few)
        stuck[size] = np.mean([run["rms"] > ACCEPTED for run in runs])
    text = ", ".join(f"NP {size}: {100 * share:.0f} %" for size, share in stuck.items())
    small, large = max(stuck[10], stuck[15], stuck[20]), max(stuck[50], stuck[100], stuck[200])
    return PaperRow(
        "population: runs without noise that end off the solution",
        "NP 10 to 20 risk local minima, 50 suffices",
        text,
        claim(
            small > 0 and large == 0,
            "some runs off with NP up to 20, none from 50 on",
            "risk and suffice, in a few runs",
        ),
        f"{few} seeds, up to 10,000 iterations, rms of total plus tensor above {ACCEPTED:g}",
    )


def _iterations(results: Results, few: int) -> PaperRow:
    runs = _found(results, EVOLUTION, few)
    when = np.array([_first(run["history"]) for run in runs])
    tight = np.array([_first(run["history"]) for run in _found(results, TIGHT, few)])
    return PaperRow(
        "NP = 50 without noise: iterations to an rms of 1e-4 nT",
        "about 2,000",
        median_and_range(when),
        number(float(np.median(when)), 2000.0, "about; the formulas of F and CR are lost"),
        f"{few} seeds; rms of our objective, offsets within +-5,200 nT; in a search space a quarter wider than "
        f"the paper's errors {median_and_range(tight)}; the printed formulas of F and CR are lost",
    )


def _first(history: Array) -> float:
    """Return the iterations until the rms is below SOLVED_NT; infinite for a search that never reaches SOLVED_NT."""
    below = np.flatnonzero(history < SOLVED_NT)
    return float(below[0] + 1) if len(below) else np.inf


def _genetic(results: Results, few: int) -> PaperRow:
    ends = np.array([run["history"][-1] for run in _found(results, GENETIC, few)])
    return PaperRow(
        "genetic algorithm, NP = 50, 10,000 iterations: rms without noise",
        "17.68",
        median_and_range(ends, "nT"),
        number(float(np.median(ends)), 17.68, "one run; the operators are not given"),
        f"{few} seeds; the paper's operators are not given: what is checked is that the evolution is far ahead",
    )


def _factors(results: Results, evolved: int) -> PaperRow:
    ide, de = (
        np.mean([run["rms"] < ACCEPTED for method in methods for run in _found(results, method, evolved)])
        for methods in improved_and_classic()
    )
    return PaperRow(
        "F from 0.2 to 0.9, CR from 0.2 to 1: runs that reach rms 0.01",
        "improved depends less on F and CR",
        f"improved {100 * ide:.0f} %, classic {100 * de:.0f} %",
        claim(ide > de, "more runs that reach it", "less has no number"),
        f"{len(FACTORS)} pairs, {evolved} seeds each, NP = 50, without noise",
    )


def _count_rows(results: Results, few: int) -> Iterable[PaperRow]:
    for n in COUNTS:
        runs = _found(results, LARGE, few, n)
        errors = np.array([run["errors"][0] for run in runs])
        rms = np.array([run["rms"] for run in runs])
        solved = errors.max() < 0.1
        yield PaperRow(
            f"{n} attitudes, no noise, NP = 200: largest offset error",
            "too few" if n < 20 else "precise" if n >= 50 else "between",
            median_and_range(errors, "nT"),
            incomparable("between the two printed counts")
            if n == 20
            else claim(solved == (n >= 50), "largest offset error below 0.1 nT from 50 on", "precise has no number"),
            f"{few} seeds; rms of total plus tensor {median_and_range(rms)}",
        )


def _least_squares_rows(results: Results, seeds: int) -> Iterable[PaperRow]:
    tried = [results[StartTask(seed)] for seed in range(seeds)]
    for name in ("nominal", *STARTS):
        share = np.mean([one[name] for one in tried])
        yield PaperRow(
            f"least squares, noise 10 nT, start: {name}",
            "depends on its start",
            f"{100 * share:.0f} % reach the minimum",
            claim(share < 1, "a start that misses", "depends on its start: one is enough"),
            f"{seeds} seeds; one start each; the minimum is that of the two-step start",
        )
