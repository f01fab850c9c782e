"""What an explanation without a name takes from an effect, and what stands beside it."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from scipy.signal import lfilter
from scipy.spatial.transform import Rotation

from diagnosis.decision.selection import select
from diagnosis.evidence.baseline import Baseline
from diagnosis.evidence.candidate_test import CandidateFit, ColouredBaseline
from diagnosis.evidence.held_out import judge_candidate, judge_settings
from diagnosis.evidence.rivals import SIZE_DIFFERS, SIZE_FOLLOWS, wander_wins, winning_rivals, with_attitude_wander
from diagnosis.library.candidates import Candidate, iron_candidates, propose_candidates
from diagnosis.policy import STANDARD
from diagnosis.problem.linear import LinearProblem
from recordings import Recording
from recordings.channels import TEMPERATURE
from scenarios.arrays import Array
from sim.effects import EFFECTS
from sim.effects.parameters import ACTIVE_WINDOW
from tests.diagnosis.synthetic import problem, recording, without_attitude

DRIVEN = next(effect for effect in EFFECTS if effect.with_role("motor") and not effect.search_role())
DRIFT = next(effect for effect in EFFECTS if any(p.unit == "nT/h" for p in effect.parameters()))
TONE = next(effect for effect in EFFECTS if effect.with_role("frequency") and effect.with_role("motor"))
WARM = next(effect for effect in EFFECTS if any(p.unit == "1/K" for p in effect.parameters()))
N = 1500
SIZES_NT = np.array([5.0, -4.0, 3.0])
X = np.linspace(-1, 1, N)[:, None]
EACH_ITS_OWN = X + X**2 * np.array([1.0, -1.0, 0.5])
TIME, FIELD = "explained better by a smooth course of time", "explained better by a smooth course of the field"
IN_PART = {ACTIVE_WINDOW.name: (90.0, 210.0)}
PLACE = "explained better by a field that changes with position"
HEADING = "explained equally well by a function of the heading"
EARTH = "explained better by a wave of the field in the earth's frame"


def _fitted(posed: LinearProblem, candidates: list[Candidate]) -> tuple[CandidateFit, Baseline, ColouredBaseline]:
    baseline, beside = Baseline.of(posed), ColouredBaseline.of(posed, ())
    found = (
        judge_settings(baseline, candidates)
        if candidates[0].window is not None
        else judge_candidate(baseline, candidates)
    )
    assert found is not None
    return beside.fit_candidate(found, beside.rows.bin(found.candidate.columns(posed))), baseline, beside


def _won(posed: LinearProblem, name: str, *, coloured: bool = True) -> str:
    """The rival that wins against the effect of a name."""
    return next(winning_rivals(*_fitted(posed, propose_candidates(posed)[name]), coloured=coloured), "")


def _with(given: Recording, added_nT: Array) -> LinearProblem:
    return problem(replace(given, mag_nT=given.mag_nT + added_nT))


def _in_body(given: Recording, field_nT: Array) -> Array:
    return np.asarray(np.einsum("nji,nj->ni", problem(given).state.R_wb, field_nT))


class TestCourses:
    """Smooth courses of time, field and place."""

    @pytest.mark.parametrize(
        ("course", "told"), [(X * np.ones(3), ""), (X + 0.7 * X**2 * np.ones(3), ""), (EACH_ITS_OWN, TIME)]
    )
    def test_a_drift_of_any_one_form_stands_and_axes_that_go_their_own_ways_are_none(
        self, course: Array, told: str
    ) -> None:
        assert _won(_with(recording(N), course * SIZES_NT), DRIFT.name) == told

    def test_what_is_fast_beside_a_slow_course_stands(self) -> None:
        """The course gains more, but does nothing of what the current does."""
        hidden: dict[str, Any] = {DRIVEN.name: {DRIVEN.linear[0]: [0.6, -0.3, 0.4]}}
        assert _won(_with(recording(N, hidden=hidden), 3 * EACH_ITS_OWN * SIZES_NT), DRIVEN.name) == ""

    @pytest.mark.parametrize(("name", "told"), [("temperature_scale", FIELD), ("diurnal_drift", "")])
    def test_a_field_that_changes_is_no_effect_that_follows_it_for_a_part(self, name: str, told: str) -> None:
        given = recording(N)
        assert _won(_with(given, _in_body(given, 3 * EACH_ITS_OWN * SIZES_NT)), name) == told

    @pytest.mark.parametrize(
        ("name", "hidden", "told"),
        [
            ("diurnal_drift", "field_gradient", PLACE),
            ("diurnal_drift", "diurnal_drift", ""),
            ("regional_field", "field_gradient", ""),
            ("field_gradient", "diurnal_drift", ""),
        ],
    )
    def test_a_field_of_places_met_one_after_the_other_is_no_change_in_time(
        self, name: str, hidden: str, told: str
    ) -> None:
        tables: dict[str, Any] = {
            "field_gradient": {"gradient_nT_m": [[0.3, 0.1, 0.2], [0.1, -0.5, 0.1], [0.2, 0.1, 0.2]]},
            "diurnal_drift": {"amplitude_enu_nT": [8.0, -5.0, 6.0], "period_s": 400.0},
        }
        assert (_won(problem(recording(hidden={hidden: tables[hidden]})), name) == PLACE) is (told == PLACE)

    def test_beside_a_clean_rest_no_course_is_tried(self) -> None:
        assert _won(_with(recording(N), EACH_ITS_OWN * SIZES_NT), DRIFT.name, coloured=False) != TIME


class TestTones:
    """Lobes of the heading and waves of the field."""

    LOBES, ALONG = 6, np.array([3.0, -2.0, 4.0])

    def _posed(self, course: Any) -> LinearProblem:
        """A course of the heading and the time, times the currents, of a vehicle that turns nearly evenly."""
        given = recording()
        assert given.current_A is not None
        R = problem(given).state.R_wb
        heading = np.unwrap(np.arctan2(R[:, 1, 0], R[:, 0, 0]))
        return _with(given, np.outer(given.current_A.sum(axis=1) * course(heading, given.time_s), self.ALONG))

    def test_what_follows_the_heading_is_no_tone(self) -> None:
        posed = self._posed(lambda heading, time_s: np.sin(self.LOBES * heading + 0.4))
        assert _won(posed, TONE.name, coloured=False) == HEADING
        assert not select(posed).accepted

    @pytest.mark.parametrize("hz", [0.108, 0.31, 1.7])
    def test_a_tone_that_does_not_keep_step_with_the_heading_is_one(self, hz: float) -> None:
        assert _won(self._posed(lambda heading, time_s: np.sin(2 * np.pi * hz * time_s)), TONE.name) == ""

    @pytest.mark.parametrize("earth", [True, False])
    def test_a_swell_is_no_motors_tone(self, earth: bool) -> None:
        """A swing of 8 s along the earth's axes, beside a current that hardly changes; or one of that current."""
        whole = recording()
        assert whole.current_A is not None
        given = replace(whole, current_A=2 + 0.05 * whole.current_A)
        wave = np.sin(2 * np.pi * given.time_s / 8)[:, None]
        current = given.current_A.sum(axis=1)[:, None]
        added = _in_body(given, 4 * wave * self.ALONG) if earth else wave * current * self.ALONG
        assert _won(_with(given, added), TONE.name, coloured=False) == (EARTH if earth else "")


class TestSizes:
    """Sizes that differ from part to part, and windows that are the middle of a course."""

    @pytest.mark.parametrize(
        ("gain", "told"),
        [
            (lambda t: np.ones(N), ""),
            (lambda t: 1 + 0.1 * np.sin(2 * np.pi * t), ""),
            (lambda t: np.where(t < 0.75, 1.0, -1.0), SIZE_DIFFERS),
            (lambda t: t < 0.5, SIZE_DIFFERS),
        ],
    )
    def test_a_gain_that_turns_round_is_none(self, gain: Any, told: str) -> None:
        given = recording(N)
        assert given.current_A is not None
        added = (gain(np.linspace(0, 1, N)) * given.current_A[:, 0])[:, None] * [3.0, -2.0, 1.0]
        assert _won(_with(given, added), DRIVEN.name) == told

    def _window(self) -> Candidate:
        iron = (several[0] for several in iron_candidates().values())
        return next(one for one in iron if not one.effect.traits.constant).at(IN_PART, 3240)

    def _growing(self, course: Array, size: float = 2e-3) -> LinearProblem:
        """A sensitivity of a course (n,) that is 0 to 1."""
        given = recording(len(course))
        given.mag_nT[:] *= 1 + size * course[:, None] * [1.0, -0.6, 0.8]
        return problem(given)

    @pytest.mark.parametrize(("name", "told"), [("switch", ""), ("bend", "time_s"), ("warm", TEMPERATURE)])
    def test_a_window_is_one_where_no_course_does_as_well(self, name: str, told: str) -> None:
        t, heat = recording(3000).time_s, recording(3000).temperature_degC
        assert heat is not None
        x = t / t[-1]
        courses = {"switch": (t >= 90) & (t < 210), "bend": x * (1 - x) * 4, "warm": (heat - 15) / 3}
        posed = self._growing(courses[name].astype(float))
        won = next(winning_rivals(*_fitted(posed, [self._window()]), coloured=False), "")
        assert won == (SIZE_FOLLOWS.format(told) if told else "")

    @pytest.mark.parametrize(("power", "told"), [(0.0, ""), (0.5, "payload")])
    def test_a_channel_that_is_on_in_the_window_does_better_or_is_the_window(self, power: float, told: str) -> None:
        """Of a payload whose level within it counts too the window is only the middle of the course."""
        t = recording(3000).time_s
        course = np.clip(1 - ((t - 150) / 60) ** 2, 0, None) ** power * ((t >= 90) & (t < 210))
        posed = self._growing(course)
        driven = replace(posed, state=replace(posed.state, channels={"payload": course}))
        won = next(winning_rivals(*_fitted(driven, [self._window()]), coloured=False), "")
        assert won == (SIZE_FOLLOWS.format(told) if told else "")


class TestWander:
    """An attitude that wanders, told from a constant turn of it and from what stands beside it."""

    LONG, MEMORY = 2000, 3000

    def _posed(
        self, seed: int, wander_deg: float, turn_deg: float = 0.0, hidden: dict[str, Any] | None = None
    ) -> LinearProblem:
        """With an attitude that wanders on the world's side, of a memory of so many samples, about a constant turn."""
        given = recording(self.LONG, hidden=hidden)
        kicks = np.random.default_rng(seed).normal(size=(self.LONG, 3)) * np.sqrt(2 / self.MEMORY)
        wander = lfilter([1.0], [1.0, -np.exp(-1 / self.MEMORY)], kicks, axis=0)
        error = Rotation.from_rotvec(np.radians(wander_deg * wander + [turn_deg, -turn_deg, 0.0]))
        true = Rotation.from_quat(given.att_q, scalar_first=True)
        return problem(replace(given, att_q=(error * true).as_quat(scalar_first=True)))

    def _wins(self, posed: LinearProblem, name: str, within: float = 0.0) -> bool:
        fit, _, beside = _fitted(posed, propose_candidates(posed)[name])
        fit = replace(fit, within=within)
        return wander_wins(fit, with_attitude_wander(beside), STANDARD.coloured_nats)

    @pytest.mark.parametrize("seed", [4, 5, 6])
    def test_the_mean_of_an_attitude_that_wanders_is_no_constant_turn_of_it(self, seed: int) -> None:
        """Beside a rest of the sensor's axes it is one by many nats."""
        assert self._wins(self._posed(seed, 0.02), "attitude_misalignment")

    @pytest.mark.parametrize(("wander_deg", "turn_deg"), [(0.0, 0.02), (0.004, 0.1)])
    def test_a_constant_turn_stands_with_a_small_wander_and_without(self, wander_deg: float, turn_deg: float) -> None:
        assert not self._wins(self._posed(1, wander_deg, turn_deg), "attitude_misalignment")

    def test_what_a_wander_does_not_take_up_stands_beside_it(self) -> None:
        hidden = {"motor_current": {"gain_nT_A": [2.4, -1.2, 1.6]}}
        assert not self._wins(self._posed(1, 0.02, hidden=hidden), "motor_current")

    def test_what_is_gained_between_the_samples_of_a_row_counts(self) -> None:
        assert not self._wins(self._posed(1, 0.02), "attitude_misalignment", within=1e3)

    def test_without_attitude_there_is_no_wander(self) -> None:
        posed = problem(without_attitude(recording(600)))
        assert with_attitude_wander(ColouredBaseline.of(posed, ())) is None
