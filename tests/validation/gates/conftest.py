"""Gates on trials that are told beforehand, so that nothing is simulated."""

from __future__ import annotations

from collections.abc import Callable, Generator, Iterable
from dataclasses import dataclass
from functools import partial
from itertools import islice
from pathlib import Path

import numpy as np
import pytest

from validation.comparison.trial import PendingTrial, Trial, TrialRow
from validation.gates.gate_file import load_gates
from validation.gates.gate_groups import GateGroup, group_gates

ROWS = dict[str, TrialRow]


def row(calibrator: str, score: float | None, status: str = "ok", reason: str = "") -> TrialRow:
    """A calibrator's row with one score; None: no estimate."""
    scores = {} if score is None else {"offset_error_nT": score, "heading_rms_deg": score}
    return TrialRow(calibrator, status, reason, scores, 0.0, 0.0)


@dataclass
class Scripted:
    """An engine whose trials come from a function of (group, run), a window at a time in another order.

    killed_after : trials after which its process ends as one that is killed.
    """

    told: Callable[[int, int], Iterable[TrialRow]]
    window: int = 1
    seed: int = 0
    computed: int = 0
    killed_after: int | None = None

    def trials(self, tasks: Iterable[PendingTrial], lost: object) -> Generator[Trial, None, None]:
        rng, source = np.random.default_rng(self.seed), iter(tasks)
        hand: list[PendingTrial] = []
        while True:
            hand += islice(source, self.window - len(hand))
            if not hand:
                return
            if self.computed == self.killed_after:
                raise KeyboardInterrupt
            task = hand.pop(int(rng.integers(len(hand))))
            self.computed += 1
            yield Trial(task.point, task.run, tuple(self.told(task.point, task.run)))


def gate_text(name: str, calibrator: str = "ellipsoid", scenario: str = "tumble", **keys: object) -> str:
    """A [[gate]] on the offset error."""
    table = {"name": name, "scenario": scenario, "calibrator": calibrator, "score": "offset_error"} | keys
    lines = (f"{key} = {value!r}" for key, value in table.items())
    return "[[gate]]\n" + "\n".join(lines) + "\n"


def groups_in(path: Path, *texts: str, **options: object) -> tuple[GateGroup, ...]:
    """The groups of a file with this text."""
    path.write_text("\n".join(texts))
    return group_gates(load_gates(path), path, **options)  # type: ignore[arg-type]


@pytest.fixture
def groups_of(tmp_path: Path) -> Callable[..., tuple[GateGroup, ...]]:
    """`groups_in` a file of the test's own."""
    return partial(groups_in, tmp_path / "gates.toml")
