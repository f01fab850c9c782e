"""Curves of channels stand in the place of names where they explain much more, and no name follows the channel."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from diagnosis import workflow
from diagnosis.evidence.baseline import Baseline
from diagnosis.evidence.localise import ChannelShare
from diagnosis.repair.channel_curves import _modelled_gap, better_channels
from diagnosis.verdict import Verdict
from recordings.channels import current_name
from tests.diagnosis.decision.answers import FOUND, case_of
from tests.diagnosis.decision.test_curves import disturbed, load
from tests.diagnosis.synthetic import problem


@pytest.mark.parametrize(
    ("channel", "explained", "instead"),
    [("load", 0.3, True), ("load", 1.0, False), (current_name(1), 0.3, False)],
    ids=["much more", "hardly more", "a name follows it"],
)
def test_curves_stand_for_names_where_they_explain_much_more(channel: str, explained: float, instead: bool) -> None:
    posed = problem(disturbed(3 * np.tanh(2 * load(0)), load=load(0)))
    case = case_of(FOUND, clean=False, explained=explained, problem=posed, where=(ChannelShare(channel, "body", 0.5),))
    found = better_channels(Baseline.of(posed), case)
    assert (found is not None) == instead
    assert not instead or "load" in {cause for one in found.named for cause in one.effect.required_inputs}
    assert better_channels(Baseline.of(posed), case_of(FOUND, clean=False, problem=posed)) is None


@pytest.mark.parametrize(("doubts", "names", "beside"), [((), 1, True), ((), 0, False), (("wrong",), 1, False)])
def test_curves_are_looked_for_beside_names_too_small_to_be_told_but_not_beside_wrong_ones(
    doubts: tuple[str, ...], names: int, beside: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    asked: list[tuple[str, ...]] = []
    monkeypatch.setattr(workflow, "follow_channels", lambda *baselines: asked.append(baselines))
    selection = SimpleNamespace(start="start", end="end", accepted=["name"] * names)
    seen: Any = SimpleNamespace(conclusion=SimpleNamespace(selection=selection, noise=None))
    workflow._curves(seen, case_of(FOUND), Verdict.UNKNOWN, doubts)
    assert asked == [("start",)] + [("start", "end")] * beside


def test_what_iron_leaves_where_it_was_not_fitted_is_no_gap_that_a_curve_explains() -> None:
    """White noise fitted to all, three times as much where the motion of the training part does not show the iron."""
    posed = problem()

    def left(use: Any = None) -> Any:
        return np.full(posed.target.shape, 1.2 if use is None else 3.0)

    start: Any = SimpleNamespace(problem=posed, residual=left, splits=[np.ones(2, bool)])
    end: Any = SimpleNamespace(
        residual=lambda use: left(), held_out_samples=lambda: np.arange(len(posed.target)) % 2 > 0
    )
    assert _modelled_gap(start, end).gap.explained == pytest.approx(0.0)
