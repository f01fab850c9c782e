"""Damaged files of a finished comparison, from which gates are proposed: one line, or the gates of the whole files."""

from __future__ import annotations

import json
import shutil
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq
import pytest
from hypothesis import strategies as st

from tests.fuzz.contract import amounts, answered, fuzz, hold
from tests.fuzz.tables import Bytes, Damage, broken_bytes, damages
from tests.fuzz.values import damaged_json
from tests.validation.comparison.conftest import small
from validation.comparison.design import Design
from validation.comparison.journal import JOURNAL, Journal
from validation.comparison.kept_columns import KEPT_COLUMNS
from validation.comparison.sealed_lines import sealed, unsealed
from validation.comparison.trial import Trial, TrialRow
from validation.comparison.trial_columns import trials_in
from validation.comparison.trial_table import TIMINGS, TRIALS, TrialTable

CASES = 20
"""Cases of each file in the normal run."""
ANSWER = "comparison.json"
BYTES, TABLES = (TRIALS, TIMINGS, JOURNAL, ANSWER), (TRIALS, TIMINGS)


@dataclass(frozen=True)
class Finished:
    """A comparison's directory, and the text of the gates that are proposed from it."""

    place: Path
    gates: str


def propose(out: Path, file: Path) -> int:
    """Ask for gates from a directory; a refusal writes no file."""
    file.unlink(missing_ok=True)
    status = hold(file.parent / "checked by text", "gate", "--init", str(out), "-o", str(file), "--json")
    assert file.exists() == (status == 0)
    return status


@pytest.fixture(scope="module")
def finished(tmp_path_factory: pytest.TempPathFactory) -> Finished:
    """Twenty trials told of two calibrators at one point."""
    place = tmp_path_factory.mktemp("finished")
    design, rng = small(), np.random.default_rng(5)
    Journal.open(place, design.identity())
    TrialTable.of(design, (told(design.calibrators, run, rng) for run in range(20))).write(place)
    (place / ANSWER).write_text(json.dumps({"ranked_by": "offset_error_nT", "trials": 20}))
    assert propose(place, place.parent / "whole.toml") == 0
    return Finished(place, (place.parent / "whole.toml").read_text())


def told(names: tuple[str, ...], run: int, rng: np.random.Generator) -> Trial:
    """A trial whose scores are drawn; the last row is the raw measurement's, and worse."""
    scale = {name: 100.0 if name == names[-1] else 1.0 + k for k, name in enumerate(names)}
    scores = [{"offset_error_nT": scale[name] * rng.uniform(0.5, 2.0)} for name in names]
    return Trial(
        0, run, tuple(TrialRow(name, "ok", "", one, 0.1, 0.1) for name, one in zip(names, scores, strict=True))
    )


def check(finished: Finished, place: Path, name: str, damage: Callable[[Path], object]) -> bool:
    """Damage a file of a copy and propose gates; returns whether that was not refused."""
    out = place / "copy"
    shutil.rmtree(out, ignore_errors=True)
    shutil.copytree(finished.place, out)
    damage(out / name)
    return propose(out, place / "gates.toml") == 0


@amounts
@pytest.mark.parametrize("name", BYTES)
def test_bytes(name: str, finished: Finished, tmp_path: Path, times: int) -> None:
    """Damage is noticed by a checksum, or changes no gate."""

    def case(one: Bytes) -> None:
        if check(finished, tmp_path, name, lambda path: path.write_bytes(one.to(path.read_bytes()))):
            assert (tmp_path / "gates.toml").read_text() == finished.gates

    fuzz(broken_bytes, case, CASES, times)


@amounts
@pytest.mark.parametrize("name", TABLES)
def test_tables(name: str, finished: Finished, tmp_path: Path, times: int) -> None:
    """Whatever another program wrote is refused, or is a table of trials."""
    table = pq.read_table(finished.place / name)

    def case(some: tuple[Damage, ...]) -> None:
        changed: pa.Table = table
        for one in some:
            changed = one.to(changed)
        check(finished, tmp_path, name, lambda path: pq.write_table(changed, path))

    fuzz(damages(table.column_names), case, CASES, times)


@amounts
@pytest.mark.parametrize("whole", [True, False], ids=["answer", "journal"])
def test_values(whole: bool, finished: Finished, tmp_path: Path, times: int) -> None:
    """Of the answer, and of a journal's first line without its checksum."""
    name = ANSWER if whole else JOURNAL
    content = (finished.place / name).read_bytes()
    known = json.loads(content) if whole else unsealed(content)

    def case(text: str) -> None:
        check(finished, tmp_path, name, lambda path: path.write_text(text, encoding="utf-8", errors="surrogateescape"))

    fuzz(damaged_json(known), case, CASES, times)


def resumed(out: Path, design: Design, trials: list[Trial]) -> None:
    """Open a journal and add what is missing: every kept trial has the figures that it had, and all are there."""
    journal = Journal.open(out, design.identity())
    assert all(one == trials[one.run] for one in journal)
    assert journal.there == {(one.point, one.run) for one in journal}
    assert list(trials_in(journal.columns(len(trials)))) == sorted(journal, key=lambda one: one.run)
    for trial in trials:
        if (trial.point, trial.run) not in journal.there:
            journal.add(trial)
    for again in (journal, Journal.open(out, design.identity())):
        assert list(trials_in(again.columns(len(trials)))) == trials


@amounts
@pytest.mark.parametrize("looks", [range(8), [3]], ids=["as it ended", "grown"])
def test_kept_columns(looks: Sequence[int], tmp_path: Path, times: int) -> None:
    """Of a journal and its columns, one or both are damaged; only a journal whose identity is damaged is refused."""
    design, rng = small(), np.random.default_rng(6)
    trials = [told(design.calibrators, run, rng) for run in range(8)]
    journal = Journal.open(tmp_path, design.identity())
    for trial in trials:
        journal.add(trial)
        if trial.run in looks:
            journal.columns(8)
    files = {name: (tmp_path / name).read_bytes() for name in (JOURNAL, KEPT_COLUMNS)}

    def case(some: dict[str, Bytes]) -> None:
        for name, content in files.items():
            (tmp_path / name).write_bytes(some[name].to(content) if name in some else content)
        if not answered(lambda: resumed(tmp_path, design, trials)):
            first = files[JOURNAL].index(b"\n") + 1
            assert (tmp_path / JOURNAL).read_bytes()[:first] != files[JOURNAL][:first]

    fuzz(st.dictionaries(st.sampled_from(list(files)), broken_bytes, min_size=1), case, CASES, times)


def test_a_bit_of_a_score(finished: Finished, tmp_path: Path) -> None:
    """One bit turned in the page of scores is refused, however likely the figure that it makes; or no figure is."""
    whole = (finished.place / TRIALS).read_bytes()
    group = pq.ParquetFile(finished.place / TRIALS).metadata.row_group(0)
    page = next(one for one in map(group.column, range(group.num_columns)) if "offset" in one.path_in_schema)
    end, refused = page.data_page_offset + page.total_compressed_size, 0
    places = range(page.data_page_offset, end, 41)
    for at in places:
        turned = whole[:at] + bytes([whole[at] ^ 4]) + whole[at + 1 :]
        if check(finished, tmp_path, TRIALS, lambda path, new=turned: path.write_bytes(new)):
            assert (tmp_path / "gates.toml").read_text() == finished.gates, at
        else:
            refused += 1
    assert refused > len(places) // 2


def test_calibrators_that_took_no_part(finished: Finished, tmp_path: Path) -> None:
    table = pq.read_table(finished.place / TRIALS)
    names = pa.array([name.replace("sphere", "spheres") for name in table.column("calibrator").to_pylist()])
    other = table.set_column(table.column_names.index("calibrator"), "calibrator", names)
    assert not check(finished, tmp_path, TRIALS, lambda path: pq.write_table(other, path))


def test_a_journal_without_a_design(finished: Finished, tmp_path: Path) -> None:
    assert not check(finished, tmp_path, JOURNAL, lambda path: path.write_bytes(sealed('{"gates":{}}')))
