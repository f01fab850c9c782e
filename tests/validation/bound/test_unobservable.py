"""What a motion cannot tell: in the parameters' names, with the angle as its cause and a remedy that holds."""

from __future__ import annotations

import re

import pytest
from scipy.spatial.transform import Rotation

from tests.calib import conftest as standard
from tests.validation.bound.experiments import along, level_turns, of_motion
from validation.bound.bound import Bound
from validation.bound.knowledge import KNOWLEDGE
from validation.bound.unobservable import observable, weak_directions


@pytest.mark.parametrize("knowledge", KNOWLEDGE)
def test_nothing_is_weak_where_all_attitudes_are_seen(knowledge: str) -> None:
    known = of_motion("full")
    bound = Bound.of(known, knowledge)
    assert weak_directions(known, bound) == ()
    assert observable(known, bound)


def test_the_vertical_offset_against_the_vertical_scale() -> None:
    """A survey that pitches and rolls by five degrees: the field keeps its angle to the vertical to within those."""
    known = of_motion("auv")
    bound = Bound.of(known, "norm")
    (weak,) = weak_directions(known, bound)
    assert {"offset_z", "S_zz"} <= set(weak.what.split(" against "))
    low, high = map(float, re.findall(r"[\d.]+(?= and| degrees)", weak.why))
    assert low == pytest.approx(27.6 - 7.1, abs=1.0)
    assert high == pytest.approx(27.6 + 7.1, abs=1.0)
    assert "body z" in weak.why
    assert not observable(known, bound)


def test_the_remedy_holds() -> None:
    """What is said of rolling for a third of the time, then pitching, is what flying it so gives."""
    known = of_motion("auv")
    (weak,) = weak_directions(known, Bound.of(known, "norm"))
    found = re.fullmatch(
        r"the same motion with the body rolled by (\d+) .*: an offset error of ([\d.]+) nT in place of .*", weak.remedy
    )
    assert found is not None, weak.remedy
    level = standard.attitude("auv", of_motion("auv", 1200).step_s.cumsum())
    parts = [Rotation.identity(), *(Rotation.from_euler(axis, -float(found[1]), degrees=True) for axis in "xy")]
    flown = along(Rotation.concatenate([level * part for part in parts]))
    assert Bound.of(flown, "norm").offset_rms_nT == pytest.approx(float(found[2]), rel=0.03)


@pytest.mark.parametrize("knowledge", KNOWLEDGE)
def test_a_level_turn_in_words(knowledge: str) -> None:
    known = level_turns()
    weak = weak_directions(known, Bound.of(known, knowledge))
    assert any("offset_z" in one.what for one in weak)
    assert all("degrees" in one.why and "in place of" in one.remedy for one in weak)
