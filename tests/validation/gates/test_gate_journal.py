"""A run of gates that was killed goes on where it was; one that ended, and other code, begin anew."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from pathlib import Path

import numpy as np
import pytest

from reports.outputs.gates import FILES, run_gates
from scenarios.errors import InputError
from tests.imports import ORDER
from tests.validation.gates.conftest import Scripted, gate_text, groups_in, row
from validation.comparison.journal import JOURNAL, Journal
from validation.comparison.trial import TrialRow
from validation.gates import gate_journal as kept

SCORES = np.exp(0.5 * np.random.default_rng(7).standard_normal((2, 400)))


def told(group: int, run: int) -> Iterable[TrialRow]:
    """Two calibrators; the second now and then without an estimate."""
    yield row("ellipsoid", SCORES[group % 2, run])
    yield row("sphere", *((None, "unobservable", "too level") if run % 5 == 0 else (SCORES[group % 2, run],)))


@pytest.fixture
def gates(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Callable[..., dict[str, str]]:
    """Runs four gates on two scenarios in one directory, and gives the text of every file that it wrote, unpainted."""
    monkeypatch.setattr("reports.outputs.gates.gates_page", lambda *outcomes: "")
    texts = (
        gate_text("good", limit=2.0),
        gate_text("near", "sphere", limit=1.3, max_trials=60),
        gate_text("bad", scenario="quad-calibration", limit=0.5),
        gate_text("against", "sphere", "quad-calibration", ratio=1.5, reference="ellipsoid"),
    )

    def run(engine: Scripted, *others: str, limit: float = 2.0) -> dict[str, str]:
        changed = texts[0].replace("2.0", str(limit))
        groups = groups_in(tmp_path / "gates.toml", *(changed, *texts[1:], *others))
        run_gates(groups, engine, tmp_path / "out", "gates.toml", 1e-4)
        return {path.name: path.read_text() for path in (tmp_path / "out").iterdir()}

    return run


@pytest.mark.parametrize("window", [1, 5])
def test_a_killed_run_goes_on_and_ends_the_same_to_the_byte(
    window: int, gates: Callable[..., dict[str, str]], tmp_path: Path
) -> None:
    whole = Scripted(told, window)
    expected = gates(whole)
    assert set(expected) == set(FILES)  # no trial outlives the run that it was made for
    made = 0
    for killed_after in (3, 30):
        killed = Scripted(told, window, seed=made, killed_after=killed_after)
        with pytest.raises(KeyboardInterrupt):
            gates(killed)
        made += killed.computed
    (tmp_path / "out" / JOURNAL).open("ab").write(b'{"point":0,"run":')  # torn by the kill
    last = Scripted(told, window, seed=99)
    assert gates(last) == expected
    assert last.computed == whole.computed - made if window == 1 else last.computed < whole.computed
    again = Scripted(told, window)
    assert gates(again) == expected
    assert again.computed == whole.computed


@pytest.mark.parametrize("change", ["nothing", "a limit", "a scenario", "the code"])
def test_what_decides_a_trial_decides_whether_it_is_kept(
    change: str, gates: Callable[..., dict[str, str]], monkeypatch: pytest.MonkeyPatch
) -> None:
    limit = 2.01 if change == "a limit" else 2.0
    others = [gate_text("more", set=["sampling.rate_hz=5"], limit=1e3)] if change == "a scenario" else []
    whole = Scripted(told)
    gates(whole, *others, limit=limit)
    with pytest.raises(KeyboardInterrupt):
        gates(Scripted(told, killed_after=20))
    if change == "the code":
        monkeypatch.setattr(kept, "_code", lambda: "another digest")
    last = Scripted(told)
    gates(last, *others, limit=limit)
    assert whole.computed - last.computed == (20 if change in ("nothing", "a limit") else 0)


def test_a_comparison_in_the_same_place_is_refused_and_left(
    gates: Callable[..., dict[str, str]], tmp_path: Path
) -> None:
    (tmp_path / "out").mkdir()
    Journal.open(tmp_path / "out", {"seed": 1})
    with pytest.raises(InputError, match="is no journal of a run of gates"):
        gates(Scripted(told))
    assert "comparison" in (tmp_path / "out" / JOURNAL).read_text()


def test_every_package_that_a_trial_can_import_is_part_of_the_identity() -> None:
    assert set(kept.DECIDING) == set(ORDER[: ORDER.index("validation") + 1])
