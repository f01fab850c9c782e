"""Rows of [Li2017]'s experiment: quadrotor survey, and Levenberg-Marquardt."""

from __future__ import annotations

import numpy as np

from papers.base import PaperRow, spread_text
from papers.judgement import claim, incomparable, number
from papers.li2017.rows import listed
from papers.li2017.trials import SOURCES, Survey
from scenarios.arrays import Array

PRINTED_LM_NT = (194_580.0, 80_290.0, 325_380.0)
FAILED = "a failure has an order of size at most"
SAMPLES_OPEN = "the paper does not say which samples and equations it solved"


def quadrotor_rows(surveys: list[Survey], without: list[Survey], one_less: list[Survey]) -> list[PaperRow]:
    """Return the rows of the survey: all error sources, without the paper's four, and without each of the four."""
    return [*_component_errors(surveys), _sources(surveys, without, one_less), _iterations(surveys)]


def _mean_nT(surveys: list[Survey], name: str) -> Array:
    """Return the component rms (3,) after a method, mean over the surveys."""
    return np.asarray(np.mean([s.rms_nT[name] for s in surveys], axis=0))


def _component_errors(surveys: list[Survey]) -> list[PaperRow]:
    raw = np.asarray(np.mean([s.raw_nT for s in surveys], axis=0))
    kf, proposed = (_mean_nT(surveys, name) for name in ("kalman", "kalman_fuzzy"))
    figures = (
        (
            "raw component error x, y, z",
            (3660.0, 4813.0, 2793.0),
            raw,
            "scenario quad-comb, whose iron is chosen to give about these",
        ),
        (
            "original filter",
            (668.0, 998.0, 851.0),
            kf,
            "the size is not reproduced: smaller, because the scenario disturbs less than the paper's site, not "
            "because the filter is better",
        ),
        ("rescaled + fuzzy", (568.0, 845.0, 761.0), proposed, "as above; rescaling alone gives the same"),
    )
    return [
        *(
            PaperRow(
                f"quadrotor: {what}",
                ", ".join(f"{v:g}" for v in paper) + " nT",
                listed(ours) + " nT rms",
                number(ours, paper, "each axis by itself; the site and its disturbances are not printed"),
                note,
            )
            for what, paper, ours, note in figures
        ),
        PaperRow(
            "quadrotor: order on every axis",
            "proposed below original below raw",
            "proposed / original " + listed(proposed / kf) + "; original / raw " + listed(kf / raw),
            claim((proposed < kf).all() and (kf < raw).all(), "both orders on all three axes", "claimed of every axis"),
            "paper: 0.85, 0.85, 0.89",
        ),
    ]


def _sources(surveys: list[Survey], without: list[Survey], one_less: list[Survey]) -> PaperRow:
    lm, without_lm = _mean_nT(surveys, "vector_lm"), _mean_nT(without, "vector_lm")
    shares = "; ".join(
        f"without {name} {listed(s.rms_nT['kalman_fuzzy'])}, least squares {listed(s.rms_nT['vector_lm'])}"
        for name, s in zip(SOURCES, one_less, strict=True)
    )
    return PaperRow(
        "quadrotor: the four named error sources removed",
        "alignment, reference field, gradient, surroundings",
        f"rescaled + fuzzy {listed(_mean_nT(without, 'kalman_fuzzy'))}, least squares of 21 parameters "
        f"{listed(without_lm)} against {listed(lm)} nT rms with them",
        claim((without_lm < lm).all(), "less on every axis", "named as sources of error, without figures"),
        f"one at a time: {shares}; at the scenario's sizes the alignment rules, the other three hardly show",
    )


def _iterations(surveys: list[Survey]) -> PaperRow:
    kf, fuzzy = ([s.settled[name] for s in surveys] for name in ("kalman", "kalman_fuzzy"))
    return PaperRow(
        "quadrotor: iterations until A settles, original and proposed",
        "149 and 29",
        f"{spread_text(kf, significant=4)} and {spread_text(fuzzy, significant=4)}",
        claim(np.median(fuzzy) < 0.5 * np.median(kf), "half as many", "29 of 149 is a fifth"),
        "sample from which all of A stays within 0.05 of its last values; settling waits for the turns, which "
        "scaling does not change; the paper's sample rate and criterion are not printed",
    )


def levenberg_marquardt_rows(runs: list[dict[str, Array]]) -> list[PaperRow]:
    """Return the rows on 21 unknowns from vector and total-field equations, with spread and consecutive samples."""
    paper = "194,580, 80,290, 325,380 nT"
    notes = {
        "vector, 200 spread": "no failure, from the start of table 1 and without any scaling",
        "total field, 200 spread": "the paper writes N equations for N points, N >= 21: the total field's, which say "
        "nothing of a rotation: the strength fits to a few nT all the same, and the components hang on rounding",
        "vector, 21 consecutive": "21 samples in a row do not excite 21 columns: the printed order of size; a likely "
        "cause found by trying, the paper does not say which samples it took",
        "total field, 21 consecutive": "both together: the printed order of size too, hanging on rounding; likely, "
        "not printed",
    }
    medians = {name: np.median([run[name] for run in runs], axis=0) for name in runs[0]}
    return [
        PaperRow(
            f"Levenberg-Marquardt, {name} samples: component errors",
            paper,
            listed(rms) + " nT rms (medians)",
            number(rms, PRINTED_LM_NT, FAILED) if name == "vector, 200 spread" else incomparable(SAMPLES_OPEN),
            notes[name],
        )
        for name, rms in medians.items()
    ]
