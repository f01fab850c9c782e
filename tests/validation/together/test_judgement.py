"""What of their noise several recordings bear out."""

from __future__ import annotations

from dataclasses import dataclass
from types import SimpleNamespace
from typing import Any

import pytest

from sim.effects import BY_NAME
from validation.diagnosis.policy import STANDARD
from validation.diagnosis.result import How, Reach
from validation.together import judgement
from validation.together.judgement import _borne_out, _is_the_sensors

TOLD, OPEN = SimpleNamespace(identified=True), SimpleNamespace(identified=False)


@dataclass(frozen=True)
class Leaves:
    """Of a belief whether what is left is white, and the noise that it is."""

    white: bool
    noise: Any = None

    @property
    def after(self) -> Any:
        return SimpleNamespace(clean=self.white)


@pytest.mark.parametrize(
    ("noise", "third", "stays"),
    [(OPEN, Leaves(True), False), (OPEN, Leaves(False), True), (TOLD, Leaves(True), True)],
)
def test_noise_of_open_nature_is_none_where_another_recording_is_white(noise: Any, third: Leaves, stays: bool) -> None:
    found = _borne_out([Leaves(False, noise), Leaves(False, noise), third])  # type: ignore[list-item]
    assert [one.noise for one in found] == ([noise, noise, None] if stays else [None] * 3)


@pytest.mark.parametrize(
    ("name", "how", "reach", "stays"),
    [
        ("offset_random_walk", How.SPECTRUM, Reach.TRANSFERRED, True),
        ("offset_random_walk", How.SPECTRUM, Reach.NOT_TRANSFERRED, False),
        ("flicker_noise", How.SPECTRUM, Reach.SOME, False),
        ("white_noise", How.SPECTRUM, Reach.SOME, True),
        ("motor_current", How.HELD_OUT, Reach.NOT_TRANSFERRED, True),
    ],
)
def test_slow_noise_of_the_sensor_has_one_size_in_all(name: str, how: How, reach: Reach, stays: bool) -> None:
    named = SimpleNamespace(how=how, effect=BY_NAME[name])
    assert _is_the_sensors(SimpleNamespace(named=named, reach=reach)) is stays  # type: ignore[arg-type]


def test_noise_of_another_size_in_each_is_in_no_lot(monkeypatch: pytest.MonkeyPatch) -> None:
    walk, white = (
        SimpleNamespace(named=SimpleNamespace(how=How.SPECTRUM, effect=BY_NAME[name]), reach=Reach.SOME)
        for name in ("offset_random_walk", "white_noise")
    )
    for name, found in {"changes_of_iron": (), "noise_of": [], "seen_by_values": [walk, white]}.items():
        monkeypatch.setattr(judgement, name, lambda *asked, found=found: found)
    lot = SimpleNamespace(chosen=[], members=[], problems=[SimpleNamespace(policy=STANDARD)])
    assert judgement._common(lot, []) == (white,)  # type: ignore[arg-type,comparison-overlap]
