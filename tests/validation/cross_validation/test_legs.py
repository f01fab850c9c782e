"""Legs: phases, headings, blocks."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from scipy.spatial.transform import Rotation

from calib.held_out.legs import BLOCKS, MOST_LEGS, legs_of
from recordings import Recording
from tests.validation.cross_validation.conftest import Made


def surveyed(yaw_deg: np.ndarray) -> Recording:
    n = len(yaw_deg)
    q = Rotation.from_euler("Z", yaw_deg[:, None], degrees=True).as_quat(scalar_first=True)
    return Recording(np.arange(n, dtype=float), np.ones((n, 3)), att_q=q)


def test_survey_lines_are_legs_though_the_heading_wavers() -> None:
    lines = np.repeat([0.0, 180.0, 0.0, 90.0, 0.0, 180.0, 0.0, 180.0], 100)
    found = legs_of(surveyed(lines + 4.0 * np.sin(np.arange(800))))
    assert (found.how, found.count) == ("headings", 8)
    assert found.sizes.tolist() == [100] * 8


def test_a_steady_turn_has_no_legs_but_blocks() -> None:
    found = legs_of(surveyed(np.linspace(0.0, 3600.0, 1000)))
    assert (found.how, found.count) == ("blocks of time", BLOCKS)
    assert np.ptp(found.sizes) <= 1


def test_phases_come_before_headings_and_many_are_joined(made: Made) -> None:
    recording = made(np.random.default_rng(0), np.eye(3))
    phase = np.array([f"leg {k // 6}" for k in range(600)])
    found = legs_of(replace(recording, phase=phase))
    assert (found.how, found.count) == ("phases", MOST_LEGS)
    three = np.repeat(["down", "turn", "up"], 200)
    assert legs_of(replace(recording, phase=three)).how == "blocks of time"
