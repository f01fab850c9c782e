"""What of their noise several recordings bear out."""

from __future__ import annotations

from dataclasses import dataclass
from types import SimpleNamespace
from typing import Any

import pytest

from diagnosis.policy import STANDARD
from diagnosis.result import How, Transfer
from diagnosis.several import selection
from diagnosis.several import verdict_rules as judgement
from diagnosis.several.transfer import There
from diagnosis.several.verdict_rules import Pool, _borne_out, _is_the_sensors, _nothing_is_left
from sim.effects import BY_NAME

TOLD, OPEN = SimpleNamespace(identified=True), SimpleNamespace(identified=False)


@dataclass(frozen=True)
class Leaves:
    """Of a belief whether what is left is white, and the noise that it is."""

    white: bool
    noise: Any = None

    @property
    def after(self) -> Any:
        return SimpleNamespace(clean=self.white)

    @property
    def clean(self) -> bool:
        return self.white or self.noise is not None


@pytest.mark.parametrize(("noise", "stays"), [(OPEN, False), (TOLD, True), (None, True)])
def test_noise_of_open_nature_is_no_finding_of_a_lot(noise: Any, stays: bool) -> None:
    belief: Any = Leaves(False, noise)
    assert _borne_out(belief) == (belief if stays else Leaves(False))


@pytest.mark.parametrize(
    ("name", "how", "reach", "stays"),
    [
        ("offset_random_walk", How.SPECTRUM, Transfer.TRANSFERRED, True),
        ("offset_random_walk", How.SPECTRUM, Transfer.NOT_TRANSFERRED, False),
        ("flicker_noise", How.SPECTRUM, Transfer.SOME, False),
        ("white_noise", How.SPECTRUM, Transfer.SOME, True),
        ("motor_current", How.HELD_OUT, Transfer.NOT_TRANSFERRED, True),
    ],
)
def test_slow_noise_of_the_sensor_has_one_size_in_all(name: str, how: How, reach: Transfer, stays: bool) -> None:
    named = SimpleNamespace(how=how, effect=BY_NAME[name])
    assert _is_the_sensors(SimpleNamespace(named=named, reach=reach)) is stays  # type: ignore[arg-type]


def test_noise_of_another_size_in_each_is_in_no_lot(monkeypatch: pytest.MonkeyPatch) -> None:
    walk, white = (
        SimpleNamespace(named=SimpleNamespace(how=How.SPECTRUM, effect=BY_NAME[name]), reach=Transfer.SOME)
        for name in ("offset_random_walk", "white_noise")
    )
    for name, found in {"changes_of_iron": (), "noise_of": [], "seen_by_values": [walk, white]}.items():
        monkeypatch.setattr(judgement, name, lambda *asked, found=found: found)
    lot = SimpleNamespace(chosen=[], members=[], problems=[SimpleNamespace(policy=STANDARD)])
    assert judgement._common(lot, []) == (white,)  # type: ignore[arg-type,comparison-overlap]


@dataclass(frozen=True)
class Chose:
    """Of a selection what a lot changes."""

    found: tuple[Any, ...] = ()
    end: Any = None
    before: Any = None
    after: Any = None


@pytest.mark.parametrize(("there", "count"), [(There.PRESENT, 1), (There.OPEN, 1), (There.ABSENT, 0)])
def test_a_recording_believes_no_effect_that_it_says_is_absent(
    there: There, count: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    ground = SimpleNamespace(beside=lambda columns: ground)
    belief = SimpleNamespace(selection=Chose())
    member = SimpleNamespace(events=[], ground=ground, seen=SimpleNamespace(belief=belief), problem=None)
    joint = SimpleNamespace(asked=[member], candidate=SimpleNamespace(columns=lambda problem: None, name="scale"))
    one = SimpleNamespace(finding=SimpleNamespace(joint=joint, there=[there]), alternatives=())
    monkeypatch.setattr(judgement, "judged_at", lambda *asked: SimpleNamespace(name="scale"))
    monkeypatch.setattr(judgement, "tests_beside", lambda *asked: None)
    monkeypatch.setattr(judgement, "believed", lambda selection: selection)
    lot = Pool([member], [one])  # type: ignore[list-item]
    assert len(lot.belief(0).found) == count


@pytest.mark.parametrize(("mode", "holds"), [("vector", False), ("strength", True)])
def test_a_source_must_show_along_the_field_where_more_than_that_is_seen(
    mode: str, holds: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(selection, "gains_along_the_field", lambda *grounds: False)
    candidate = SimpleNamespace(effect=BY_NAME["local_dipole"])
    found = SimpleNamespace(there=[There.PRESENT] * 2, joint=SimpleNamespace(candidate=candidate))
    members = [SimpleNamespace(ground=None, problem=SimpleNamespace(mode=mode))] * 2
    assert selection._along_the_field(found, members, members) is holds  # type: ignore[arg-type]


def test_slow_noise_without_a_name_in_the_lot_is_left() -> None:
    each: Any = [Leaves(False, TOLD), Leaves(False, TOLD), Leaves(True)]
    names: Any = [SimpleNamespace()]
    assert [_nothing_is_left(one, each) for one in ([], names)] == [False, True]
