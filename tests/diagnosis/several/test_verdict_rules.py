"""What of their noise several recordings bear out."""

from __future__ import annotations

from dataclasses import dataclass
from types import SimpleNamespace
from typing import Any

import pytest

from diagnosis.policy import STANDARD
from diagnosis.result import EvidenceKind, Transfer
from diagnosis.several import selection
from diagnosis.several import verdict_rules as judgement
from diagnosis.several.transfer import Presence
from diagnosis.several.verdict_rules import Pool, _is_clean, _is_sensor_noise, _without_open_noise
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
    conclusion: Any = Leaves(False, noise)
    assert _without_open_noise(conclusion) == (conclusion if stays else Leaves(False))


@pytest.mark.parametrize(
    ("name", "how", "transfer", "stays"),
    [
        ("offset_random_walk", EvidenceKind.SPECTRUM, Transfer.TRANSFERRED, True),
        ("offset_random_walk", EvidenceKind.SPECTRUM, Transfer.NOT_TRANSFERRED, False),
        ("flicker_noise", EvidenceKind.SPECTRUM, Transfer.SOME, False),
        ("white_noise", EvidenceKind.SPECTRUM, Transfer.SOME, True),
        ("motor_current", EvidenceKind.HELD_OUT, Transfer.NOT_TRANSFERRED, True),
    ],
)
def test_slow_noise_of_the_sensor_has_one_size_in_all(
    name: str, how: EvidenceKind, transfer: Transfer, stays: bool
) -> None:
    named = SimpleNamespace(kind=how, effect=BY_NAME[name])
    assert _is_sensor_noise(SimpleNamespace(named=named, transfer=transfer)) is stays  # type: ignore[arg-type]


def test_noise_of_another_size_in_each_is_in_no_lot(monkeypatch: pytest.MonkeyPatch) -> None:
    walk, white = (
        SimpleNamespace(named=SimpleNamespace(kind=EvidenceKind.SPECTRUM, effect=BY_NAME[name]), transfer=Transfer.SOME)
        for name in ("offset_random_walk", "white_noise")
    )
    for name, found in {"common_iron_changes": (), "named_noise": [], "common_value_effects": [walk, white]}.items():
        monkeypatch.setattr(judgement, name, lambda *_, found=found: found)
    pool = SimpleNamespace(effects=[], recordings=[], problems=[SimpleNamespace(policy=STANDARD)])
    assert judgement._common_effects(pool, []) == (white,)  # type: ignore[arg-type,comparison-overlap]


@dataclass(frozen=True)
class Chose:
    """Of a selection what a lot changes."""

    accepted: tuple[Any, ...] = ()
    end: Any = None
    before: Any = None
    after: Any = None


@pytest.mark.parametrize(("there", "count"), [(Presence.PRESENT, 1), (Presence.UNDECIDED, 1), (Presence.ABSENT, 0)])
def test_a_recording_believes_no_effect_that_it_says_is_absent(
    there: Presence, count: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    baseline = SimpleNamespace(with_columns=lambda columns: baseline)
    conclusion = SimpleNamespace(selection=Chose())
    recording = SimpleNamespace(
        events=[], baseline=baseline, examination=SimpleNamespace(conclusion=conclusion), problem=None
    )
    pooled = SimpleNamespace(
        in_recordings=[recording], candidate=SimpleNamespace(columns=lambda problem: None, name="scale")
    )
    one = SimpleNamespace(finding=SimpleNamespace(pooled=pooled, presence=[there]), alternatives=())
    monkeypatch.setattr(judgement, "judge_settings", lambda *in_recording: SimpleNamespace(name="scale"))
    monkeypatch.setattr(judgement, "tests_with_effects", lambda *in_recording: None)
    monkeypatch.setattr(judgement, "conclude", lambda selection: selection)
    pool = Pool([recording], [one])  # type: ignore[list-item]
    assert len(pool.conclusion(0).accepted) == count


@pytest.mark.parametrize(("mode", "holds"), [("vector", False), ("strength", True)])
def test_a_source_must_show_along_the_field_where_more_than_that_is_seen(
    mode: str, holds: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(selection, "explains_along_field", lambda *baselines: False)
    candidate = SimpleNamespace(effect=BY_NAME["local_dipole"])
    found = SimpleNamespace(presence=[Presence.PRESENT] * 2, pooled=SimpleNamespace(candidate=candidate))
    recordings = [SimpleNamespace(baseline=None, problem=SimpleNamespace(mode=mode))] * 2
    assert selection._along_the_field(found, recordings, recordings) is holds  # type: ignore[arg-type]


def test_slow_noise_without_a_name_in_the_lot_is_left() -> None:
    each: Any = [Leaves(False, TOLD), Leaves(False, TOLD), Leaves(True)]
    names: Any = [SimpleNamespace()]
    assert [_is_clean(one, each) for one in ([], names)] == [False, True]


def test_the_strongest_effect_is_told_first(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(judgement, "common_fitted_effect", lambda effect, problems: effect)
    for name in ("common_iron_changes", "common_value_effects"):
        monkeypatch.setattr(judgement, name, lambda *_: [])
    effects = [SimpleNamespace(strength=strength) for strength in (2.0, 5.0, 3.0)]
    pool = SimpleNamespace(effects=effects, recordings=[], problems=[SimpleNamespace(policy=STANDARD)])
    found = judgement._common_effects(pool, [])  # type: ignore[arg-type]
    assert [one.strength for one in found] == [5.0, 3.0, 2.0]  # type: ignore[attr-defined]
