"""Several recordings examined elsewhere: the diagnosis of one process."""

from __future__ import annotations

import pickle
from collections.abc import Callable, Generator, Sequence
from pathlib import Path
from typing import TypeVar

import pytest

from diagnosis.question import Question, answer, file_sources
from magbench.api.diagnosis_results import diagnosis_result
from sim.dataset_writer import generate
from tests.short import short

Item = TypeVar("Item")
Result = TypeVar("Result")


class Elsewhere:
    """A cluster that gets and gives bytes, the last item first."""

    def map(
        self, function: Callable[[Item], Result], items: Sequence[Item]
    ) -> Generator[tuple[Item, Result], None, None]:
        """Compute copies of the items."""
        for item in reversed(items):
            yield item, pickle.loads(pickle.dumps(function(pickle.loads(pickle.dumps(item)))))


@pytest.mark.slow
def test_recordings_examined_elsewhere_give_the_same_diagnosis(tmp_path: Path) -> None:
    generate(short("tumble"), tmp_path, runs=2)
    sources, question = file_sources([tmp_path], None), Question.about(None)
    told: list[str] = []
    here = diagnosis_result(answer(question, sources))
    there = diagnosis_result(answer(question, sources, say=told.append, cluster=Elsewhere()))
    assert there.as_dict() == here.as_dict()
    assert told[:2] == [f"{tmp_path.name} run 1: examined", f"{tmp_path.name} run 0: examined"]
