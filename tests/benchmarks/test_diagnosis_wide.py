"""The truths of wide families: forms against closed formulas, strengths as asked, answers held strictly."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from benchmarks.diagnosis.score import figures
from benchmarks.diagnosis.wide.courses import STEP_S, Course
from benchmarks.diagnosis.wide.field import gradient
from benchmarks.diagnosis.wide.forms import answered, lagged
from benchmarks.diagnosis.wide.making import _beside_iron, _through, hidden_in
from benchmarks.diagnosis.wide.noises import powers
from benchmarks.diagnosis.wide.rests import _random_phases
from benchmarks.diagnosis.wide.sensor import filtered, late, plays
from benchmarks.diagnosis.wide.table import FAMILIES, FAULTS
from diagnosis.evidence.direct import direct_evidence
from diagnosis.problem.formulation import pose_model
from sim.effects import BY_NAME
from sim.rotation import matrix_from_q, q_from_rotation_vector


@pytest.fixture(scope="module")
def course() -> Course:
    """Turning about three axes, on circles that rise, with two currents."""
    t = STEP_S * np.arange(20_000)
    angles = np.stack([0.8 * np.sin(t / 5), 0.6 * np.sin(t / 7 + 1), 2 * np.sin(t / 11)], axis=1)
    q = q_from_rotation_vector(angles)
    place = np.stack([20 * np.cos(t / 30), 20 * np.sin(t / 30), 0.02 * t], axis=1)
    currents = np.stack([1 + np.sin(t / 9), 1 + 0.5 * np.cos(t / 4)], axis=1)
    field = np.array([1e3, 2e4, -4e4])
    return Course(t, q, matrix_from_q(q), place, np.zeros((len(t), 3)), currents, 10 + 3 * np.sin(t / 60), field, 5)


def test_every_family_is_of_an_effect() -> None:
    assert set(FAMILIES) | set(FAULTS) <= set(BY_NAME)


@pytest.mark.parametrize("name", FAMILIES)
def test_a_form_has_the_strength_that_is_asked(name: str, course: Course) -> None:
    with_it, without = (
        _through(course, hidden, np.zeros((3, 3)), np.zeros(3), 2.0, np.random.default_rng(3))
        for hidden in ({name: 0.3}, {})
    )
    assert _beside_iron(with_it - without, without) == pytest.approx(0.6, rel=0.02)


def test_a_continuous_filter_answers_a_tone_by_its_formula() -> None:
    """Gain ``1 / sqrt(1 + (w tau)^2)`` and a phase of ``-atan(w tau)``; a ramp comes out tau late."""
    t, w, tau = STEP_S * np.arange(6000), 2 * np.pi * 0.31, 0.7
    inside = slice(1500, 4500)
    out = lagged(np.sin(w * t)[:, None], tau)[:, 0]
    expected = np.sin(w * t - np.arctan(w * tau)) / np.hypot(1, w * tau)
    assert np.abs(out - expected)[inside].max() < 2e-3
    ramp = lagged(t[:, None], tau)[:, 0]
    assert np.abs(ramp - (t - tau))[inside].max() < 1e-6
    same = answered(np.sin(w * t)[:, None], lambda f: np.ones(len(f), dtype=np.complex128))
    assert same[:, 0] == pytest.approx(np.sin(w * t), abs=1e-9)


def test_a_delay_and_a_slow_low_pass_are_the_field_as_it_was(course: Course) -> None:
    for family, rng in ((late, 0), (filtered, 0)):
        added = family(np.random.default_rng(rng), course, course.field_nT)(1.0)
        rate = np.gradient(course.field_nT, STEP_S, axis=0)
        c = (added * rate).sum() / (rate * rate).sum()
        left = added - c * rate
        assert c < 0
        assert np.sqrt((left**2).mean() / (added**2).mean()) < 0.25


def test_a_gradient_of_second_order_has_no_sources(course: Course) -> None:
    """No divergence and no curl, by differences over a cell of places seen without a turn."""
    h, n = 0.5, 6
    steps = h * np.concatenate([np.eye(3), -np.eye(3)])
    place = np.concatenate([np.array([3.0, -2.0, 4.0]) + steps, course.pos_enu_m[::100]])
    still = replace(course, pos_enu_m=place, R_wb=np.tile(np.eye(3), (len(place), 1, 1)))
    world = gradient(np.random.default_rng(1), still, still.field_nT)(1.0)
    J = (world[:3] - world[3:n]) / (2 * h)  # (along, component)
    assert abs(np.trace(J)) < 1e-9 * np.abs(J).max()
    assert np.abs(J - J.T).max() < 1e-9 * np.abs(J).max()


def test_a_memory_goes_round_a_loop(course: Course) -> None:
    """It is bounded by its widths, and differs on the way up and down."""
    swing = 2e4 * np.sin(course.time_s / 8)[:, None] * np.ones(3)
    added = plays(np.random.default_rng(2), course, swing)(1.0)[5000:, 0]
    up = np.gradient(swing[5000:, 0]) > 0
    middle = np.abs(swing[5000:, 0]) < 1e3
    assert added[up & middle].mean() < 0 < added[~up & middle].mean()


def test_noise_falls_with_its_power() -> None:
    x = powers(np.random.default_rng(0), 2**15, 2.0)
    assert np.sqrt((x**2).mean()) == pytest.approx(1.0, rel=0.05)
    power = (np.abs(np.fft.rfft(x, axis=0)) ** 2).mean(axis=1)
    low, high = power[20:60].mean(), power[200:600].mean()
    assert np.log10(low / high) == pytest.approx(2.0, abs=0.3)


def test_random_phases_keep_spectrum_and_covariance() -> None:
    rng = np.random.default_rng(4)
    rest = np.cumsum(rng.normal(size=(4000, 3)), axis=0) @ np.array([[1, 0.5, 0], [0, 1, 0], [0, 0, 0.2]])
    rest -= rest.mean(axis=0)
    made = np.stack([_random_phases(rest, 6000, np.random.default_rng(k)) for k in range(4)])
    assert np.cov(made.reshape(-1, 3).T) == pytest.approx(np.cov(rest.T), rel=0.3, abs=0.15 * rest.var())
    assert np.diff(made, axis=1).std() < 0.1 * made.std()


def _row(hidden: str, verdict: str, names: list[tuple[str, list[str], str]]) -> dict[str, object]:
    return {
        "kind": "wide-single", "hidden": [hidden], "strengths": [0.3], "verdict": verdict, "names": names,
        "explained": None, "seconds": 1.0, "colour": None, "parameters": {},
    }  # fmt: skip


def test_an_equivalent_alone_is_confidently_wrong() -> None:
    """A low-pass is no eddy current, unless the answer says that it may be either."""
    alone = _row("bandwidth", "named", [("eddy_current", [], "held-out")])
    listed = _row("bandwidth", "class", [("latency", ["bandwidth"], "held-out")])
    wrong, right = (figures([row])["wide single, 0.3 sigma"] for row in (alone, listed))
    assert (wrong["first_right"], wrong["confidently_wrong"], wrong["one_name"]) == (0, 1, 0)
    assert (right["first_right"], right["confidently_wrong"], right["one_name"]) == (1, 0, 1)


def test_a_second_name_is_one_too_many() -> None:
    two = [("hysteresis", [], "held-out"), ("nonlinearity", [], "held-out")]
    found = figures([_row("hysteresis", "composite", two)])["wide single, 0.3 sigma"]
    assert (found["in_class"], found["one_name"], found["extra_names"]) == (1, 0, 1)


def test_the_slow_noise_of_the_rest_is_no_name_too_many() -> None:
    """It was put there; beside a white rest, or one of attitude alone, it is one too many."""
    two = [("hysteresis", [], "held-out"), ("offset_random_walk", [], "spectrum")]
    rows = [_row("hysteresis", "composite", two) | {"colour": colour} for colour in ("walk", None, "attitude, walk")]
    found = [figures([row])["wide single, 0.3 sigma"] for row in rows]
    assert [(one["one_name"], one["extra_names"]) for one in found] == [(1, 0), (0, 1), (0, 1)]


def test_fast_turns_are_no_spikes() -> None:
    """A quadrotor that sways, seen at a low rate, jumps from sample to sample, with the motion; wrong values stay."""
    turning, wrong = (hidden_in("quadrotor", (name,), (1.0,), 4) for name in ("offset_jump", "spikes"))
    assert direct_evidence(pose_model(turning.recording, turning.model, None, None)) == []
    assert [d.effect.name for d in direct_evidence(pose_model(wrong.recording, wrong.model, None, None))] == ["spikes"]
