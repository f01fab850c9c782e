"""What the bound says of scores is what fits with its errors score."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from calib.result import Calibration, Status
from sim.effects import EFFECTS
from tests.calib import conftest as standard
from tests.validation.bound.experiments import level_turns, of_motion
from validation.bound.bound import Bound
from validation.bound.experiment import Experiment
from validation.bound.knowledge import KNOWLEDGE
from validation.bound.score_bounds import score_bounds
from validation.scoring.hold_out import Environment, hold_out
from validation.scoring.scores import score

DRAWS = 120
BY_NAME = {effect.name: effect for effect in EFFECTS}
ENU_NT = np.array(standard.FIELD_ENU_NT)
STRETCHED = np.array([[1.6, 0.2, 0.0], [0.2, 1.0, -0.1], [0.0, -0.1, 0.7]])
"""A sensor whose errors, corrected by it, are far from symmetric."""


def known_of(motion: str) -> Experiment:
    return replace(of_motion(motion), field_enu_nT=ENU_NT, matrix=STRETCHED)


def drawn_scores(known: Experiment, bound: Bound) -> dict[str, np.ndarray]:
    """Scores of calibrations whose errors have the bound's covariance, by the project's own scoring."""
    iron = (
        BY_NAME["soft_iron"](matrix=tuple(map(tuple, STRETCHED - np.eye(3)))),  # type: ignore[call-arg]
        BY_NAME["hard_iron"](offset_nT=tuple(standard.HARD_NT)),  # type: ignore[call-arg]
    )
    truth = hold_out(iron, Environment(ENU_NT))
    np.testing.assert_allclose(truth.matrix, STRETCHED, atol=1e-9)
    drawn = np.random.default_rng(5).normal(size=(DRAWS, len(bound.covariance)))
    white = np.linalg.qr(drawn)[0] * np.sqrt(DRAWS)  # of exactly unit covariance: nothing is left to chance
    errors = white @ np.linalg.cholesky(bound.covariance).T
    found: dict[str, list[float]] = {}
    for error in errors:
        soft = STRETCHED.copy()
        for (i, j), value in zip(bound.information.places, error[3:] / bound.strength_nT, strict=True):
            soft[i, j] += value
            if not bound.information.includes_rotation and i != j:
                soft[j, i] += value
        offset_nT, matrix = truth.offset_nT + error[:3], np.linalg.inv(soft)
        fit = Calibration(name="drawn", status=Status("ok"), offset_nT=offset_nT, matrix=matrix)
        for one in score(fit, standard.recording("full", 0, n=50), truth, not bound.information.includes_rotation):
            found.setdefault(one.name, []).append(one.value)
    return {name: np.array(values) for name, values in found.items()}


@pytest.mark.parametrize("knowledge", ["norm", "vector"])
def test_the_scores_of_fits_at_the_bound(knowledge: str) -> None:
    known = known_of("full")
    bound = Bound.of(known, knowledge)
    scores = drawn_scores(known, bound)
    for use in score_bounds(known, bound):
        values = scores[use.meaning.name]
        if use.meaning.name == "figure_of_merit":
            assert use.value == pytest.approx(values.mean(), rel=0.1)
        else:
            assert use.value == pytest.approx(np.sqrt(np.mean(values**2)), rel=0.01), use.meaning.name


def test_without_the_fields_direction_the_strength_alone() -> None:
    known = of_motion("full")
    assert [use.meaning.name for use in score_bounds(known, Bound.of(known, "norm"))] == ["holdout_sphere_norm_rms"]


@pytest.mark.parametrize("knowledge", KNOWLEDGE)
def test_a_level_turn_does_not_tell_the_strength(knowledge: str) -> None:
    known = replace(level_turns(), field_enu_nT=ENU_NT)
    told = {use.meaning.name: use.value for use in score_bounds(known, Bound.of(known, knowledge))}
    assert told["holdout_sphere_norm_rms"] == np.inf


def test_at_the_pole_there_is_no_heading() -> None:
    known = replace(of_motion("full"), field_enu_nT=np.array([0.0, 0.0, standard.REFERENCE.strength_nT]))
    assert {use.meaning.name: use.value for use in score_bounds(known, Bound.of(known, "norm"))}[
        "heading_rms"
    ] == np.inf


def test_an_unknown_strength_costs_nothing_but_the_scale() -> None:
    """Against the strength as a tenth parameter, and the trace of S as a measurement of great weight."""
    known = of_motion("pitch")
    bound = Bound.of(known, "norm", strength_known=False)
    places, strength = bound.information.places, bound.strength_nT
    units = np.diag([1.0] * 3 + [strength] * 6)
    by_strength = np.array([0.0] * 3 + [known.matrix[i, j] / strength for i, j in places])
    J = units @ np.column_stack([np.eye(9), by_strength / np.diag(units)])
    trace = np.array([0.0] * 3 + [float(i == j) for i, j in places] + [0.0])
    information = J.T @ bound.information.matrix @ J + 1e12 * np.outer(trace, trace)
    scale = np.sqrt(np.diag(information))
    covariance = np.linalg.inv(information / np.outer(scale, scale)) / np.outer(scale, scale)
    np.testing.assert_allclose(bound.offset_std_nT, np.sqrt(np.diag(covariance)[:3]), rtol=1e-3)
    expected = np.zeros((3, 3))
    for (i, j), value in zip(places, np.sqrt(np.diag(covariance)[3:9]), strict=True):
        expected[i, j] = expected[j, i] = value
    np.testing.assert_allclose(bound.matrix_std, expected, rtol=1e-3)
    assert bound.offset_rms_nT == pytest.approx(Bound.of(known, "norm").offset_rms_nT)


def test_the_figure_of_merit_does_not_follow_rounding() -> None:
    """Scale factors with one variance have no axes of their own: the last digits of the information choose them."""
    known = replace(of_motion("full"), field_enu_nT=ENU_NT)
    bound = Bound.of(known, "vector")
    rounding = np.random.default_rng(3).normal(size=bound.information.matrix.shape)
    merits = [
        score_bounds(known, replace(bound, information=replace(bound.information, matrix=matrix)))[-1].value
        for matrix in (bound.information.matrix, bound.information.matrix * (1.0 + 1e-13 * (rounding + rounding.T)))
    ]
    assert merits[0] == pytest.approx(merits[1], rel=1e-9)
