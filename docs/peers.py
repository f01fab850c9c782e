"""The table of `peers.md`: the page's own command run, and its comparison read.

The packages need an environment of their own. `make pictures` runs the command with the Python of MAGBENCH_PEERS,
and leaves the table as it is without.
"""

from __future__ import annotations

import json
import os
import shlex
import tempfile
from pathlib import Path

from validation.scoring.definitions import SCORE_DEFINITIONS
from validation.text import figure

PAGE = Path(__file__).parent / "peers.md"
VARIABLE = "MAGBENCH_PEERS"
PYTHON = "peers/bin/python"
"""What the page's command calls the packages' Python."""
SCORES = ("offset_error", "matrix_error", "holdout_sphere_component_rms", "heading_rms")
RESULT = "comparison.json"


def asked() -> bool:
    """Whether there is an environment to make the table in."""
    return bool(os.environ.get(VARIABLE))


def command() -> list[str]:
    """The words of the page's comparison, without the program's name."""
    text = PAGE.read_text(encoding="utf-8").replace("\\\n", " ")
    (line,) = (line for line in text.splitlines() if line.startswith("magbench compare "))
    return shlex.split(line)[1:]


def compared() -> list[tuple[str, ...]]:
    """The table's rows, from the page's command run anew (half an hour)."""
    from magbench.cli import main

    with tempfile.TemporaryDirectory() as folder:
        words = [word.replace(PYTHON, os.environ[VARIABLE]) for word in command()]
        words[words.index("-o") + 1] = folder
        status = main(words)
        if status != 0:
            raise RuntimeError(f"{PAGE.name}: its command ended with status {status}")
        return rows(Path(folder))


def heads() -> tuple[str, ...]:
    """The table's head: the scores as reports call them."""
    shown = [SCORE_DEFINITIONS[name] for name in SCORES]
    return ("calibrator", *(f"{one.short}, {one.unit}" if one.unit else one.short for one in shown), "failed")


def rows(comparison: Path) -> list[tuple[str, ...]]:
    """A row a calibrator in the order of the command: the median of each score, and the trials without an answer."""
    found = json.loads((comparison / RESULT).read_text(encoding="utf-8"))
    cells = {(row["calibrator"], row["score"]): row for row in found["table"]}
    return [
        (
            f"`{name}`",
            *(_median(cells[name, score]["median"]) for score in SCORES),
            f"{cells[name, SCORES[0]]['failures']} of {found['trials']}",
        )
        for name in found["calibrators"]
    ]


def _median(value: float | None) -> str:
    return "none" if value is None else figure(value)
