"""What the report's pictures show of an outcome, read back from their lines."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from reports.plots.effects import draw_effect_sizes
from reports.plots.field import draw_norm, draw_residuals
from reports.plots.motion import draw_path, draw_vehicle
from reports.text.outcome import rms_length
from tests.reports import outcome_example as example
from validation.scoring.outcome import Outcome


@pytest.fixture(scope="module")
def outcome() -> Outcome:
    return example.example_outcome(1200)


def drawn(axis: Any, label: str) -> np.ndarray:
    (line,) = [line for line in axis.lines if line.get_label() == label]
    return np.asarray(line.get_ydata())


def test_strength_and_its_error(outcome: Outcome) -> None:
    whole, zoom = draw_norm(outcome).axes
    truth_nT = np.linalg.norm(outcome.truth.field_nT, axis=1)
    np.testing.assert_allclose(drawn(whole, "truth"), truth_nT)
    np.testing.assert_allclose(drawn(whole, "raw"), np.linalg.norm(outcome.recording.mag_nT, axis=1))
    for name in outcome.shown():
        error_nT = np.linalg.norm(outcome.corrected[name], axis=1) - truth_nT
        np.testing.assert_allclose(drawn(zoom, name), error_nT, atol=1e-9)


def test_residuals_are_named_with_their_size(outcome: Outcome) -> None:
    for axis, name in zip(draw_residuals(outcome).axes, outcome.shown(), strict=True):
        assert axis.get_title(loc="left").startswith(name) or axis.get_title().startswith(name)
        np.testing.assert_allclose(np.asarray(axis.lines[0].get_ydata()), outcome.residual_nT(name)[:, 0])


def test_the_length_of_a_bar_is_the_effects_rms(outcome: Outcome) -> None:
    axis = draw_effect_sizes(outcome).axes[0]
    ends = [float(np.asarray(line.get_xdata())[-1]) for line in axis.lines]
    assert ends == pytest.approx([rms_length(value) for value in outcome.effects.values()])
    assert [label.get_text() for label in axis.get_yticklabels()] == list(outcome.effects)


def test_the_path_is_coloured_by_phase(outcome: Outcome) -> None:
    figure = draw_path(outcome)
    above = figure.axes[1]
    assert len(above.lines) == len(outcome.phases())
    east = np.concatenate([np.asarray(line.get_xdata()) for line in above.lines])
    assert (east.min(), east.max()) == (outcome.truth.pos_enu_m[:, 0].min(), outcome.truth.pos_enu_m[:, 0].max())
    assert [text.get_text() for text in figure.legends[0].get_texts()] == ["descent", "spiral", "comb"]


def test_the_vehicles_rows_are_what_was_recorded(outcome: Outcome) -> None:
    labels = [axis.get_ylabel() for axis in draw_vehicle(outcome).axes]
    assert labels == ["yaw, unwrapped (°)", "pitch, roll (°)", "temperature (°C)", "motor current (A)"]
    yaw = np.asarray(draw_vehicle(outcome).axes[0].lines[0].get_ydata())
    assert np.ptp(yaw) > 700
    assert np.abs(np.diff(yaw)).max() < 180
