"""Journal of an interrupted gate run, valid for equal scenarios, calibrators and code."""

from __future__ import annotations

import hashlib
from collections.abc import Callable, Sequence
from pathlib import Path

import validation
from recordings.files import sha256_of
from validation.comparison.journal import Journal
from validation.gates.gate_groups import GateGroup

RUN_OF_GATES = "run of gates"
DECIDING = ("calib", "recordings", "scenarios", "sim", "validation")
"""Packages whose code determines a trial."""


def open_gate_journal(
    groups: Sequence[GateGroup], out: Path, warn: Callable[[str], object] = lambda text: None
) -> Journal:
    """Open the journal of a gate run in a directory; trials of a different run or different code are dropped.

    Limits are not part of the identity, since limits determine no trial. A gate judges the current code, so trials of
    earlier code are useless, unlike in a comparison. warn : gets a message about damaged lines. Raises InputError
    where the directory holds a comparison.
    """
    identity = {"groups": [_shortened(group) for group in groups], "code": _code()}
    return Journal.open(out, identity, RUN_OF_GATES, anew=True, warn=warn)


def _shortened(group: GateGroup) -> dict[str, object]:
    """Return the identity of a group's design with a single point, since all points are equal."""
    identity = group.design.identity()
    return identity | {"points": identity["points"][-1:]}


def _code() -> str:
    """Return a digest over every file of the packages that determine a trial."""
    found = hashlib.sha256()
    root = Path(validation.__file__).parent.parent
    for package in DECIDING:
        for path in sorted((root / package).rglob("*")):
            if path.is_file() and "__pycache__" not in path.parts:
                found.update(f"{path.relative_to(root)} {sha256_of(path)}\n".encode())
    return found.hexdigest()
