"""Which channels a gap goes with: in means of what length they are asked, and how many are listed."""

from __future__ import annotations

import numpy as np
import pytest

from diagnosis.evidence import localise as module
from diagnosis.evidence.localise import channels, localise
from tests.diagnosis.synthetic import problem


@pytest.mark.parametrize(("share", "count"), [(0.002, 0), (0.004, 8)])
def test_eight_channels_are_listed_that_explain_three_thousandths(
    share: float, count: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    posed = problem(n=1000)
    monkeypatch.setattr(module, "explained_share", lambda *_: share)
    assert len(list(channels(posed))) > 8
    assert len(localise(posed, np.ones((1000, 3)))) == count


@pytest.mark.parametrize(("n", "means"), [(4000, 800), (1000, 500)])
def test_means_are_of_half_a_second_and_four_hundred_at_least(
    n: int, means: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    """At ten samples a second."""
    monkeypatch.setattr(module, "explained_share", lambda channel, *_: float(len(channel)))
    assert {one.share for one in localise(problem(n=n), np.ones((n, 3)))} == {float(means)}
