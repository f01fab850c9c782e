"""Every registered phase: exact derivatives, continuity, rest at the ends; and what each path promises."""

from typing import Any, get_args

import numpy as np
import pytest
from pydantic import TypeAdapter, ValidationError
from scipy.spatial.transform import Rotation

from scenarios.paths import PHASES, REFERENCE_COLUMNS, Phase, PhaseBase, Start

START = Start((100.0, -50.0, -30.0), 0.7)
EXCITED = {"roll_amplitude_deg": 20, "roll_period_s": 11, "pitch_amplitude_deg": 30, "pitch_period_s": 17}
EXAMPLES: dict[str, dict[str, Any]] = {
    "descent": {"to_depth_m": 3000},
    "ascent": {},
    "spiral": {"radius_m": 20, "turn_rate_deg_s": -3, "vertical_speed_m_s": -0.05, "turns": 2, **EXCITED},
    "comb": {"line_length_m": 60, "line_spacing_m": 20, "lines": 4, "speed_m_s": 1.5, **EXCITED},
    "hover": {"duration_s": 60},
    "rotate": {"duration_s": 90},
    "poses": {
        "poses": [
            {"yaw_deg": 170, "pitch_deg": 20, "roll_deg": -10, "move_s": 12, "hold_s": 4},
            {"yaw_deg": -150, "pitch_deg": -25, "roll_deg": 30, "move_s": 15, "hold_s": 6},
        ]
    },
    "pushes": {
        "pushes": [{"yaw_deg": 100, "pitch_deg": 20, "roll_deg": -15}, {"yaw_deg": 30, "roll_deg": 20, "times": 3}]
    },
    "turntable_stops": {"axis": "pitch", "stops": 7, "step_deg": 25, "dwell_s": 3, "move_s": 2},
    "turntable_turns": {"rate_deg_s": 12},
    "tumble": {"duration_s": 120, "roll_phase_deg": 17, "pitch_phase_deg": 63},
}
X, V, A, ANGLE, RATE, BEND = (slice(3 * k, 3 * k + 3) for k in range(6))


def phase(kind: str, **parameters: Any) -> PhaseBase:
    return PHASES[kind].model_validate({"kind": kind, **EXAMPLES[kind], **parameters})


def end_s(one: PhaseBase) -> float:
    return min(one.duration_s, 400.0)


def test_table_and_union_agree() -> None:
    assert set(get_args(get_args(Phase)[0])) == set(PHASES.values())
    assert all(get_args(cls.model_fields["kind"].annotation) == (kind,) for kind, cls in PHASES.items())
    assert set(EXAMPLES) == set(PHASES)


@pytest.mark.parametrize("speed", [0.0, 0.8])
@pytest.mark.parametrize("kind", PHASES)
def test_derivatives_are_those_of_the_values(kind: str, speed: float) -> None:
    one, h = phase(kind), 1e-4
    start = Start(START.pos_enu_m, START.yaw_rad, speed)
    t = np.random.default_rng(1).uniform(h, end_s(one) - h, 2000)
    before, now, after = (one.reference(start, t + d) for d in (-h, 0.0, h))
    assert now.shape == (2000, len(REFERENCE_COLUMNS))
    slope = (after - before) / (2 * h)
    for value, derivative in ((X, V), (V, A), (ANGLE, RATE), (RATE, BEND)):
        # where a third derivative jumps, the central difference is off by h times the jump
        np.testing.assert_allclose(slope[:, value], now[:, derivative], atol=2e-4)


@pytest.mark.parametrize("kind", PHASES)
def test_accelerations_are_continuous(kind: str) -> None:
    one = phase(kind)
    step = {n: _largest_step(one, n) for n in (20_000, 80_000)}
    assert np.all(step[80_000] < 0.3 * step[20_000] + 1e-9)  # a jump would not shrink with the interval


def _largest_step(one: PhaseBase, n: int) -> Any:
    reference = one.reference(START, np.linspace(0.0, end_s(one), n))
    return np.abs(np.diff(reference, axis=0)).max(axis=0)


@pytest.mark.parametrize("kind", PHASES)
def test_begins_at_the_vehicle_at_rest(kind: str) -> None:
    first = phase(kind).reference(START, np.zeros(1))[0]
    np.testing.assert_allclose(first[X], START.pos_enu_m)
    np.testing.assert_allclose(first[ANGLE], (START.yaw_rad, 0.0, 0.0))
    np.testing.assert_allclose(np.r_[first[V], first[A], first[RATE], first[BEND]], 0.0, atol=1e-12)


@pytest.mark.parametrize("kind", ["hover", "spiral", "comb"])
def test_takes_over_the_speed_at_the_start(kind: str) -> None:
    first = phase(kind).reference(Start((0, 0, 0), 0.7, 0.8), np.zeros(1))[0]
    np.testing.assert_allclose(first[V], 0.8 * np.array([np.cos(0.7), np.sin(0.7), 0.0]))


@pytest.mark.parametrize(
    "kind", ["comb", "hover", "rotate", "poses", "pushes", "turntable_stops", "turntable_turns", "tumble"]
)
def test_ends_level_at_rest_and_stays(kind: str) -> None:
    one = phase(kind)
    last = one.reference(START, one.duration_s + np.array([0.0, 5.0]))
    np.testing.assert_allclose(last[:, 3:9], 0.0, atol=1e-9)
    np.testing.assert_allclose(last[:, 12:], 0.0, atol=1e-9)
    np.testing.assert_allclose(np.sin(last[:, 10:12] / 2), 0.0, atol=1e-9)
    np.testing.assert_allclose(last[0], last[1], atol=1e-9)


@pytest.mark.parametrize("kind", PHASES)
def test_blocks_equal_the_whole(kind: str) -> None:
    one = phase(kind)
    t = np.linspace(0.0, end_s(one), 1001)
    blocks = np.vstack([one.reference(START, part) for part in np.array_split(t, 13)])
    np.testing.assert_array_equal(blocks, one.reference(START, t))


@pytest.mark.parametrize("kind", ["spiral", "comb"])
def test_nose_follows_the_path(kind: str) -> None:
    one = phase(kind)
    r = one.reference(START, np.linspace(1.0, one.duration_s - 1.0, 500))
    speed = np.hypot(r[:, 3], r[:, 4])
    np.testing.assert_allclose(r[:, 3], speed * np.cos(r[:, 9]), atol=1e-9)
    np.testing.assert_allclose(r[:, 4], speed * np.sin(r[:, 9]), atol=1e-9)


def test_spiral_has_its_radius_rate_and_turns() -> None:
    one = phase("spiral")
    r = one.reference(START, np.linspace(one.settle_s, one.duration_s, 2000))
    centre = np.array(START.pos_enu_m[:2]) + 20.0 * np.array([np.sin(0.7), -np.cos(0.7)])  # to the right
    np.testing.assert_allclose(np.hypot(*(r[:, :2] - centre).T), 20.0, rtol=1e-12)
    np.testing.assert_allclose(np.degrees(r[:, 12]), -3.0, rtol=1e-12)
    np.testing.assert_allclose(r[:, 5], -0.05, rtol=1e-12)
    assert np.degrees(r[-1, 9] - 0.7) == pytest.approx(-720.0)


def test_excitation_reaches_its_amplitudes() -> None:
    r = phase("spiral").reference(START, np.linspace(0, 200, 20_001))
    assert np.degrees(np.abs(r[:, 10]).max()) == pytest.approx(30, abs=0.1)
    assert np.degrees(np.abs(r[:, 11]).max()) == pytest.approx(20, abs=0.1)


@pytest.mark.parametrize("first_turn", ["left", "right"])
def test_comb_lines_are_straight_parallel_and_spaced(first_turn: str) -> None:
    one = phase("comb", first_turn=first_turn)
    t = np.linspace(0.0, one.duration_s, 20_001)
    r = one.reference(START, t)
    cos, sin = np.cos(0.7), np.sin(0.7)
    east, north = (r[:, :2] - START.pos_enu_m[:2]).T
    ahead, aside = cos * east + sin * north, (cos * north - sin * east) * (1 if first_turn == "left" else -1)
    on_line = (ahead >= 0) & (ahead <= 60)
    np.testing.assert_allclose(np.sin(r[on_line, 9] - 0.7), 0.0, atol=1e-12)
    np.testing.assert_allclose(aside[on_line] / 20, np.round(aside[on_line] / 20), atol=1e-9)
    assert set(np.round(aside[on_line] / 20).astype(int)) == {0, 1, 2, 3}
    assert aside[ahead > 60].min() >= -1e-9
    assert aside[ahead > 60].max() <= 60 + 1e-9
    np.testing.assert_allclose((ahead[-1], aside[-1]), (0.0, 60.0), atol=1e-6)


def test_comb_keeps_its_speed_in_the_turns() -> None:
    one = phase("comb")
    r = one.reference(START, np.linspace(20.0, one.duration_s - 20.0, 3000))
    np.testing.assert_allclose(np.hypot(r[:, 3], r[:, 4]), 1.5, rtol=1e-12)


def test_rotate_tilts_in_body_x_then_body_y() -> None:
    one = phase("rotate", duration_s=128, tilt_period_s=4, tilt_amplitude_deg=15, turn_rate_deg_s=0)
    r = one.reference(Start((0, 0, 0), 0.0), np.linspace(0, 128, 12_801))
    tilt = np.degrees(np.arctan(np.abs(r[:, 6:8]) / 9.81))
    assert tilt[500:1200, 0].max() == pytest.approx(15, abs=0.1)
    assert tilt[:1600, 1].max() == 0.0
    assert tilt[2100:2800, 1].max() == pytest.approx(15, abs=0.1)


def test_poses_are_held_as_they_are_named() -> None:
    one = phase("poses")
    r = one.reference(Start((0, 0, 0), 3.0), np.array([12.1, 15.9, 31.1, 36.9]))
    np.testing.assert_allclose(np.degrees(r[:, 9:12]), [[170, 20, -10]] * 2 + [[210, -25, 30]] * 2, atol=1e-9)
    np.testing.assert_allclose(r[:, 12:], 0.0, atol=1e-12)


def test_a_push_needs_the_attitude_that_it_names_and_leads_back() -> None:
    """The body's z axis along gravity's reaction plus the acceleration, by rotation matrices."""
    one = phase("pushes")
    t = np.linspace(0.0, one.duration_s, 20_001)
    r = one.reference(Start((0, 0, 0), 0.0), t)
    named = Rotation.from_euler("ZYX", [100, 20, -15], degrees=True).apply([0.0, 0.0, 1.0])
    first = r[(t > 5.0 + 1.5 + 0.7) & (t < 5.0 + 1.5 + 1.4)]
    needed = np.column_stack([first[:, 6:8], np.full(len(first), 9.81)])
    np.testing.assert_allclose(needed / np.linalg.norm(needed, axis=1)[:, None], [named] * len(first), atol=1e-12)
    np.testing.assert_allclose(r[-1, :3], 0.0, atol=1e-9)
    between = r[np.searchsorted(t, 5.0 + one.length_s(one.pushes[0]))]  # type: ignore[attr-defined]
    np.testing.assert_allclose(between[:6], 0.0, atol=0.02)


def test_twelve_stops_rest_at_multiples_of_30_degrees_clockwise() -> None:
    one = PHASES["turntable_stops"].model_validate({"kind": "turntable_stops"})
    middle = 10.0 + 25.0 * np.arange(12)
    r = one.reference(Start((0, 0, 0), 0.0), middle)
    np.testing.assert_allclose(np.degrees(r[:, 9]), -30.0 * np.arange(12), atol=1e-9)
    np.testing.assert_allclose(r[:, 12:], 0.0, atol=1e-12)
    assert np.degrees(one.reference(Start((0, 0, 0), 0.0), np.array([one.duration_s]))[0, 9]) == pytest.approx(-360)


def test_turns_are_full_about_each_axis_in_sequence() -> None:
    one = phase("turntable_turns")
    quarter = one.duration_s / 4
    r = one.reference(Start((0, 0, 0), 0.0), quarter * np.arange(5))
    turns = r[:, 9:12] / (2 * np.pi)  # yaw, pitch, roll
    np.testing.assert_allclose(turns, [[0, 0, 0], [0, 0, 1], [0, 1, 1], [1, 1, 1], [2, 2, 2]], atol=1e-9)


def test_tumble_covers_the_sphere() -> None:
    one = phase("tumble", duration_s=360)
    r = one.reference(Start((0, 0, 0), 0.0), np.arange(0, 360, 0.1))
    yaw, pitch, roll = r[:, 9:12].T
    third_row = np.column_stack([-np.sin(pitch), np.cos(pitch) * np.sin(roll), np.cos(pitch) * np.cos(roll)])
    octants = {tuple(row) for row in np.sign(third_row[np.abs(third_row).min(axis=1) > 0.2]).astype(int)}
    assert len(octants) == 8
    assert abs(yaw[-1]) > 6 * np.pi


def test_unpowered_phases_end_at_their_depth() -> None:
    descent, ascent = phase("descent"), phase("ascent")
    assert (descent.end_depth_m, ascent.end_depth_m) == (3000, 5)
    assert not descent.powered
    assert descent.model_dump()["net_weight_N"] == -PHASES["ascent"].model_validate({"kind": "ascent"}).ballast_N  # type: ignore[attr-defined]


@pytest.mark.parametrize(
    ("kind", "wrong"),
    [
        ("spiral", {"turn_rate_deg_s": 0}),
        ("spiral", {"duration_s": 300}),
        ("spiral", {"turns": None}),
        ("spiral", {"turns": 0.2}),
        ("comb", {"run_in_s": 600}),
        ("rotate", {"duration_s": 10}),
        ("tumble", {"run_in_s": 100}),
        ("turntable_stops", {"step_deg": 0}),
        ("turntable_turns", {"run_in_s": 50}),
        ("descent", {"to_depth_m": -1}),
    ],
)
def test_refuses_what_cannot_be_done(kind: str, wrong: dict[str, Any]) -> None:
    phase(kind)
    with pytest.raises(ValidationError):
        phase(kind, **wrong)


def test_union_picks_the_class_by_kind() -> None:
    adapter = TypeAdapter[PhaseBase](Phase)
    assert type(adapter.validate_python({"kind": "hover"})) is PHASES["hover"]
