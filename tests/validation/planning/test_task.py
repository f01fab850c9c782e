"""What a plan is for: the vehicle's and the scenario's own values, information before and during the flight."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from scenarios.errors import InputError
from scenarios.toml import as_dict
from sim.scenario import load
from sim.vehicles import VEHICLES
from validation.bound.bound import Bound
from validation.bound.limit import Tilts
from validation.planning.manoeuvre import HandHeld, Leg, Pushed, manoeuvre_of
from validation.planning.task import HAND, PlanningTask, _resting, based, in_field

LIKE = load("standard-full")


@pytest.fixture(scope="module")
def auv() -> PlanningTask:
    return PlanningTask.of("auv", LIKE, noise_std_nT=10.0)


def test_a_vehicle_and_a_person_have_tilts_and_times_of_their_own(auv: PlanningTask) -> None:
    hand = PlanningTask.of(HAND, LIKE, noise_std_nT=10.0)
    assert auv.tilts == Tilts(*VEHICLES["auv"].tilts_deg)
    assert (auv.usual_s, auv.step_deg, auv.linked) == (600.0, None, False)
    assert (hand.usual_s, hand.step_deg, hand.tilts) == (120.0, 45.0, Tilts(180.0, 90.0))
    assert isinstance(hand.manoeuvre, HandHeld)
    assert hand.manoeuvre.turning_deg_s == 45.0
    assert PlanningTask.of(HAND, LIKE, tilts=Tilts(45.0, 45.0), noise_std_nT=1.0).tilts == Tilts(45.0, 45.0)
    assert np.max(np.abs(auv.angles_deg[:, 1])) == auv.tilts.pitch_deg
    assert set(np.unique(hand.angles_deg % 45.0)) == {0.0}


@pytest.mark.parametrize("heading_deg", [35.0, -120.0])
def test_a_plan_begins_at_the_vehicle_s_heading(heading_deg: float) -> None:
    like = load("auv-spiral", [f"vehicle.heading_deg={heading_deg}"])
    assert PlanningTask.of("auv", like, noise_std_nT=10.0).manoeuvre.yaw_deg == pytest.approx(heading_deg, abs=1e-3)


def test_gyro_methods_are_linked_and_others_are_not(auv: PlanningTask) -> None:
    linked = [replace(auv, knowledge=knowledge).linked for knowledge in ("norm", "vector", "norm+gyro")]
    assert linked == [False, False, True]


def test_a_quadrotor_changes_wide_tilts_more_slowly_so_that_it_follows() -> None:
    slow = PlanningTask.of("quadrotor", LIKE, tilts=Tilts(0.0, 45.0), noise_std_nT=10.0).manoeuvre
    assert isinstance(slow, Pushed)
    assert slow.switch_s == pytest.approx(2 * 1.875 * 9.80665 / 40.0, abs=0.006)  # g tan 45 to -g, at most 40 m/s^3
    with pytest.raises(InputError, match="at most 45"):
        PlanningTask.of("quadrotor", LIKE, tilts=Tilts(46.0, 20.0), noise_std_nT=10.0)


def test_information_adds_and_error_is_its_inverse(auv: PlanningTask) -> None:
    size = len(auv.wanted)
    assert auv.error_before == np.inf
    assert auv.error(np.zeros((size, size))) == np.inf
    told = np.diag([0.25] * 3 + [1.0] * (size - 3))
    assert auv.error(told) == pytest.approx(np.sqrt(3 / 0.25))  # of the offset's three parts
    later = auv.going_on(3.0 * told, 77.0)
    assert later.manoeuvre.yaw_deg == 77.0
    assert later.error_before == pytest.approx(np.sqrt(3 / 0.75))
    assert later.error_with(told) == pytest.approx(np.sqrt(3.0))
    assert auv.error_with(told) == auv.error(told)


def test_a_phase_tells_the_sum_of_its_parts(auv: PlanningTask) -> None:
    phase = auv.manoeuvre.phase([Leg(0.0, 10.0, 5.0, 4.0), Leg(90.0, -10.0, 0.0, 6.0)])
    middle = 0.5 * round(phase.duration_s)
    whole = auv.information(phase, 0.0, phase.duration_s)
    parts = auv.information(phase, 0.0, middle) + auv.information(phase, middle, phase.duration_s)
    np.testing.assert_allclose(parts, whole, rtol=1e-9, atol=1e-12 * np.abs(whole).max())
    np.testing.assert_array_equal(auv.phase_information(phase), whole)
    assert auv.interval_s == pytest.approx(1.0 / LIKE.sampling.rate_hz)


def test_the_scenario_keeps_a_vehicle_of_its_kind_and_nothing_of_the_old_flight() -> None:
    ways = ['vary."effects.white_noise.std_nT".uniform=[1, 30]', 'vary."phases.0.duration_s".uniform=[100, 200]']
    like = load("auv-spiral", ways)
    rest, still = ([manoeuvre_of(name).phase([Leg(0.0, 0.0, 0.0, 1.0)])] for name in ("auv", "quadrotor"))
    same, other = based("auv", like, rest, "sphere"), based("quadrotor", like, still, "sphere")
    assert same.vehicle == like.vehicle
    assert other.vehicle.kind == "quadrotor"
    assert set(same.vary) == {"effects.white_noise.std_nT"}
    assert same.calibrators == ("sphere",)
    assert [phase.kind for phase in same.phases] == ["poses"]


def test_the_noise_is_measured_long_enough(auv: PlanningTask) -> None:
    lengths = [phase.duration_s for phase in _resting(auv.base).phases]
    assert 200.0 <= sum(lengths) < 200.0 + lengths[0]  # 6,000 values at 10 Hz, whose rms is known to one percent


def test_the_noise_is_measured_level_and_at_rest(auv: PlanningTask) -> None:
    (phase,) = as_dict(auv.base)["phases"]
    assert [
        {key: pose.get(key, 0.0) for key in ("yaw_deg", "pitch_deg", "roll_deg", "hold_s")} for pose in phase["poses"]
    ] == [{"yaw_deg": 0.0, "pitch_deg": 0.0, "roll_deg": 0.0, "hold_s": 1.0}]


def test_a_manoeuvre_begins_to_the_east_without_drag_unless_it_is_said() -> None:
    assert Pushed(20.0) == Pushed(20.0, yaw_deg=0.0, drag_1_m=0.0)
    assert manoeuvre_of("quadrotor").yaw_deg == 0.0
    assert manoeuvre_of("quadrotor", 30.0).yaw_deg == 30.0
    assert manoeuvre_of("quadrotor").drag_1_m == VEHICLES["quadrotor"].drag_1_m


def test_a_phase_with_a_gyro_tells_what_its_attitudes_are_bound_by(auv: PlanningTask) -> None:
    """Field and turns between samples are those of the attitudes: a yaw of 90 degrees turns east into the nose."""
    asked = replace(auv, knowledge="norm+gyro")
    phase = asked.manoeuvre.phase([Leg(90.0, 0.0, 0.0, 2.0)])
    meant = asked.meant(phase)
    held = slice(-15, -5)
    east, north, up = meant.field_enu_nT
    np.testing.assert_allclose(meant.field_nT[held], np.tile([north, -east, up], (10, 1)), atol=1e-6)
    assert len(meant.turns) == len(meant.step_s) == len(meant.field_nT) - 1
    assert set(meant.step_s) == {asked.interval_s}
    turned = meant.field_nT[0]
    for turn in meant.turns:
        turned = turn @ turned
    np.testing.assert_allclose(turned, meant.field_nT[-1], atol=1e-4)
    np.testing.assert_allclose(asked.phase_information(phase), Bound.of(meant, "norm+gyro").information.matrix)


def test_another_field_is_the_only_change() -> None:
    other = in_field(LIKE, (1.0, 2.0, 3.0))
    assert other.field.enu_nT == (1.0, 2.0, 3.0)
    assert other.phases == LIKE.phases
