"""Rows of [Ding2021]'s two simulations: parameter errors, common minimum, weights, tensor."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

import numpy as np

from papers.base import PaperRow
from papers.ding2021.trials import BASELINE_M, SpreadTask
from papers.judgement import Judged, claim, error_size, number
from scenarios.arrays import Array
from validation.text import figure

NOISES_NT = (2.0, 5.0, 10.0)
QUANTITIES = ("offset", "scale", "non-orthogonality", "misalignment")
UNITS = ("nT", "", "deg", "deg")
PRINTED = {
    (1, 0): (0.367, 0.909, 1.825),
    (1, 2): (0.001, 0.003, 0.006),
    (2, 0): (0.339, 0.844, 1.715),
    (2, 2): (0.001, 0.003, 0.006),
    (2, 1): (2.2e-5, 5.6e-5, 1.13e-4),
}
"""Largest errors by (simulation, quantity), at the three noises."""
PRINTED_RMS = {"total": 7.327, "Bxx": 0.379, "Bxy": 0.211, "Bxz": 0.151, "Byy": 0.044, "Byz": 0.075}
ALONE_NT = 10.0 / np.sqrt(3.0)
"""Standard deviation of noise uniform within 10 nT."""
NOISE_ALONE = 0.1
"""Deviation from the noise's own rms that 48 fitted parameters explain."""
Results = dict[Any, Any]


def simulation_rows(results: Results, seeds: int, evolved: int) -> Iterable[PaperRow]:
    """Yield the rows of both simulations at each noise."""
    yield from _exact(results, seeds, evolved)
    for (case, quantity), printed in PRINTED.items():
        for noise, printed_figure in zip(NOISES_NT, printed, strict=True):
            yield error_row(results, seeds, case, quantity, noise, printed_figure)
    yield _same_minimum(results, evolved)
    yield _weights(results, evolved)
    yield _systematic(results, seeds)
    yield from _tensor_rms(results, seeds)


def median_and_range(values: Array, unit: str = "") -> str:
    """Return median and range as text."""
    low, middle, high = np.quantile(values, (0.0, 0.5, 1.0))
    return f"median {figure(middle)} ({figure(low, 2)} to {figure(high, 2)}) {unit}".strip()


def _of(results: Results, key: str, case: int, noise: float, seeds: int, common: bool = False) -> Array:
    """Return a result of the spread's trials by seed, without trials that lack the result."""
    kinds = [SpreadTask(case, noise, seed, common, evolve) for seed in range(seeds) for evolve in (False, True)]
    return np.array([results[task][key] for task in kinds if task in results and key in results[task]])


def _evolved(results: Results, key: str, evolved: int) -> Array:
    """Return a result of the trials with evolution at 10 nT of noise, of simulations 1 and 2 together."""
    return np.concatenate([_of(results, key, case, 10.0, evolved) for case in (1, 2)])


def _exact(results: Results, seeds: int, evolved: int) -> Iterable[PaperRow]:
    for case in (1, 2):
        errors = _of(results, "evolved_errors", case, 0.0, evolved)
        both = np.concatenate((errors, _of(results, "errors", case, 0.0, seeds)))
        rms = _of(results, "rms", case, 0.0, seeds)
        good = both[:, 0].max() < 1e-3 and both[:, 2].max() < 1e-6
        yield PaperRow(
            f"simulation {case}, no noise: all 48 parameters",
            "exact; total 52,000 nT, tensor 0",
            f"largest offset error {figure(both[:, 0].max(), 1)} nT, angle {figure(both[:, 2:].max(), 1)} deg, scale "
            f"{figure(both[:, 1].max(), 1)}; tensor {figure(rms[:, 1:].max(), 1)} nT/m",
            claim(good, "offsets to 1e-3 nT, angles to 1e-6 deg", "exact, to the rounding of the search"),
            f"evolution alone ({evolved} seeds) and least squares ({seeds} seeds)",
        )


def error_row(results: Results, seeds: int, case: int, quantity: int, noise: float, printed: float) -> PaperRow:
    """Return the row of a printed parameter error."""
    ours = _of(results, "errors", case, noise, seeds)[:, quantity]
    two = _of(results, "two_step", case, noise, seeds)[:, quantity]
    over = _of(results, "over_bound", case, noise, seeds)
    inside = ours.min() <= printed <= ours.max()
    note = (
        f"{seeds} seeds; the paper's single draw lies {'inside' if inside else 'outside'} our spread, at its "
        f"{100 * np.mean(ours < printed):.0f} % point; errors are {np.sqrt(np.mean(over**2)):.2f} times the "
        f"Cramer-Rao deviation, rms; two-step: median {figure(np.median(two))}"
    )
    return PaperRow(
        f"simulation {case}, noise {noise:g} nT: largest error of {QUANTITIES[quantity]}",
        f"{printed:g} {UNITS[quantity]}".strip(),
        median_and_range(ours, UNITS[quantity]),
        error_size(ours, printed),
        note,
    )


def _same_minimum(results: Results, evolved: int) -> PaperRow:
    apart = _evolved(results, "evolved_apart", evolved)
    return PaperRow(
        "noise 10 nT: evolution and least squares with a good start",
        "evolution clearly better with noise",
        f"largest difference of a parameter {figure(apart.max(), 1)} standard deviations",
        claim(apart.max() >= 0.01, "a hundredth of a standard deviation", "less apart is the same minimum"),
        f"{len(apart)} seeds: the same objective has the same minimum; a better result of either is another "
        "objective or an unfinished search. Hence least squares stands for the evolution in the spreads",
    )


def _weights(results: Results, evolved: int) -> PaperRow:
    apart = _evolved(results, "weights", evolved)
    errors = _evolved(results, "weights_errors", evolved)
    usual = _evolved(results, "evolved_errors", evolved)[:, 0]
    ratio = np.median(errors, axis=0) / np.median(usual)
    return PaperRow(
        "weights of the objective (formula lost in print)",
        "not given",
        f"largest offset error {ratio.min():.2f} to {ratio.max():.2f} times that with weights 1, 1, 0",
        claim(ratio.max() < 1.3, "1.3 times the error", "no effect beyond the scatter of a few arrays"),
        f"components 1/3 and 3, tensor 0 and 3, invariants 1; estimates move by at most {apart.max():.2f} "
        f"standard deviations; medians over {len(usual)} arrays",
    )


def _systematic(results: Results, seeds: int) -> PaperRow:
    level = _of(results, "systematic", 1, 10.0, seeds)
    shared = _of(results, "systematic", 1, 10.0, seeds, common=True)
    offset_nT = np.median(_of(results, "bound_offset_nT", 1, 10.0, seeds))
    return PaperRow(
        "simulation 1, noise 10 nT: corrected tensor without the noise itself, largest",
        "below 0.2 nT/m",
        median_and_range(level, "nT/m"),
        claim(np.median(level) < 0.2, "median below 0.2 nT/m", "printed as a limit"),
        f"the same noise on all four sensors: {median_and_range(shared, 'nT/m')}; offsets known to no better than "
        f"{offset_nT:.2f} nT (largest Cramer-Rao deviation) forbid 0.2 nT/m over {BASELINE_M:g} m",
    )


def _noise_law(ours: Array, common: Array, printed: float, alone: float) -> Judged:
    """Return another noise law where ours is the effect of the stated noise alone and the printed number is not.

    alone : rms that the stated noise, uniform within 10 nT and independent on each axis, leaves by itself
    """
    usual = number(float(np.median(ours)), printed, "rms over two hundred attitudes")
    if usual.verdict == "same number" or abs(np.median(ours) / alone - 1) > NOISE_ALONE:
        return usual
    limit = f"ours within {100 * NOISE_ALONE:.0f} % of {figure(alone)}, the stated noise alone; printed outside"
    return Judged("another noise law", limit, f"the same noise on all sensors gives {figure(np.median(common))}")


def _tensor_rms(results: Results, seeds: int) -> Iterable[PaperRow]:
    floor = np.sqrt(2.0) * (10.0 / np.sqrt(3.0)) / BASELINE_M
    ours = _of(results, "rms", 2, 10.0, seeds)
    common = _of(results, "rms", 2, 10.0, seeds, common=True)
    for column, (name, printed) in enumerate(PRINTED_RMS.items()):
        unit = "nT" if column == 0 else "nT/m"
        note = f"the same noise on all four sensors: {median_and_range(common[:, column], unit)}"
        if not column:
            note = f"10 / sqrt 3 = {ALONE_NT:.2f} nT is the stated noise: a larger printed rms is no worse fit. {note}"
        if column:
            note = (
                f"sqrt(2) s / d = {floor:.1f} nT/m from white noise alone, so the printed figure cannot hold with "
                f"noise of its own on each sensor; {note}, the size that is printed"
            )
        yield PaperRow(
            f"simulation 2, noise 10 nT: rms of {name} after",
            f"{printed:g} {unit}",
            median_and_range(ours[:, column], unit),
            _noise_law(ours[:, column], common[:, column], printed, ALONE_NT if not column else floor),
            note,
        )
