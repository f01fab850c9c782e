"""Which trials are asked of an engine, in which order, and what is said when the engine is lost."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import dataclass, field
from hashlib import sha256
from pathlib import Path

import pytest

from scenarios.errors import InputError
from validation.comparison.design import Design
from validation.comparison.engine import ENDED, GoneError, Trials, new_trials, run_trials
from validation.comparison.journal import Journal
from validation.comparison.sealed_lines import matches, sealed, unsealed
from validation.comparison.trial import PendingTrial, Trial, TrialRow

Place = tuple[int, int]


def told(point: int, run: int) -> Trial:
    return Trial(point, run, (TrialRow("sphere", "ok", "", {"offset_error_nT": 1.0 + run}, 0.1, 0.1),))


@dataclass
class Told:
    """An engine that tells trials, loses some, and is gone after `most`."""

    lost: tuple[Place, ...] = ()
    most: int = 100
    asked: list[Place] = field(default_factory=list)

    def trials(self, tasks: Iterable[PendingTrial], on_loss: Callable[[PendingTrial], Trial]) -> Trials:
        for task in tasks:
            if len(self.asked) == self.most:
                raise GoneError("has not answered for 1 s", where="--scheduler x", do="start it again")
            self.asked.append((task.point, task.run))
            yield on_loss(task) if (task.point, task.run) in self.lost else told(task.point, task.run)


def test_all_points_of_a_run_are_asked_before_the_next_run(design: Design) -> None:
    engine = Told()
    assert [(one.point, one.run) for one in new_trials(design, [4, 2], engine)] == engine.asked
    assert engine.asked == [(0, 4), (1, 4), (0, 2), (1, 2)]


def test_kept_trials_of_the_wanted_runs_come_first_and_are_not_asked(design: Design, tmp_path: Path) -> None:
    journal, engine = Journal.open(tmp_path, design.identity()), Told()
    for place in ((0, 1), (1, 0), (0, 7)):
        journal.add(told(*place))
    found = [(one.point, one.run) for one in run_trials(design, range(2), engine, journal)]
    assert found == [(0, 1), (1, 0), (0, 0), (1, 1)]
    assert engine.asked == [(0, 0), (1, 1)]
    assert sorted((one.point, one.run) for one in journal) == [(0, 0), (0, 1), (0, 7), (1, 0), (1, 1)]
    assert [one for one in Journal.open(tmp_path, design.identity()) if one.run == 7] == [told(0, 7)]


def test_a_trial_given_twice_is_kept_once(design: Design, tmp_path: Path) -> None:
    journal = Journal.open(tmp_path, design.identity())
    for run in (0, 0, 1):
        journal.add(told(0, run))
    assert list(journal) == [told(0, 0), told(0, 1)]
    assert journal.there == {(0, 0), (0, 1)}
    assert Journal.open(tmp_path, design.identity()).there == {(0, 0), (0, 1)}
    journal.remove()
    assert not journal.there
    assert not journal.path.exists()


def test_a_lost_trial_is_failed_for_all(design: Design) -> None:
    (good, lost) = new_trials(design, [0], Told(lost=((1, 0),)))
    assert good == told(0, 0)
    assert (lost.point, lost.run, {row.reason for row in lost.rows}) == (1, 0, {ENDED})


@pytest.mark.parametrize(("most", "kept"), [(0, "no trial kept"), (1, "1 trial kept"), (2, "2 trials kept")])
def test_an_engine_that_is_gone_leaves_what_has_landed(design: Design, tmp_path: Path, most: int, kept: str) -> None:
    journal = Journal.open(tmp_path, design.identity())
    with pytest.raises(InputError, match=f"has not answered for 1 s; {kept}"):
        list(run_trials(design, range(3), Told(most=most), journal))
    assert len(list(journal)) == most
    with pytest.raises(InputError, match="; no trial is kept"):
        list(run_trials(design, range(3), Told(most=most)))


def test_a_journal_of_another_design_is_refused_or_begun_anew(design: Design, tmp_path: Path) -> None:
    Journal.open(tmp_path, {"seed": 1}, "run of gates").add(told(0, 0))
    with pytest.raises(InputError, match="holds another run of gates: "):
        Journal.open(tmp_path, {"seed": 2}, "run of gates")
    assert list(Journal.open(tmp_path, {"seed": 1}, "run of gates", anew=True)) == [told(0, 0)]
    assert list(Journal.open(tmp_path, {"seed": 2}, "run of gates", anew=True)) == []


def test_a_line_is_sealed_by_half_of_its_digest() -> None:
    line = sealed('{"a":1}')
    digest = sha256(b'"a":1}\n').hexdigest()
    assert line == b'{"sha256":"' + digest[:32].encode() + b'","a":1}\n'
    assert matches(line)
    assert unsealed(line) == {"sha256": digest[:32], "a": 1}
    assert unsealed(line.replace(b"1}", b"2}")) is None
