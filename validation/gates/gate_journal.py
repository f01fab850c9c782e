"""Trials of a run of gates that was killed, kept where they hold still: the same scenarios, calibrators and code."""

from __future__ import annotations

import hashlib
from collections.abc import Sequence
from pathlib import Path

import validation
from recordings.files import sha256_of
from validation.comparison.journal import Journal
from validation.gates.gate_groups import GateGroup

RUN_OF_GATES = "run of gates"
DECIDING = ("calib", "recordings", "scenarios", "sim", "validation")
"""The packages whose code decides a trial."""


def open_gate_journal(groups: Sequence[GateGroup], out: Path) -> Journal:
    """The trials that a run of these gates left in a directory; of another run, or of other code, none.

    Limits are not asked for: they decide no trial. A gate says whether the code as it stands is good enough, and so one
    trial made by the code of before would be worth less than none: unlike a comparison it takes none over.
    Raises InputError where the directory holds a comparison.
    """
    identity = {"groups": [_shortened(group) for group in groups], "code": _code()}
    return Journal.open(out, identity, RUN_OF_GATES, anew=True)


def _shortened(group: GateGroup) -> dict[str, object]:
    """A group's points are all the same."""
    identity = group.design.identity()
    return identity | {"points": identity["points"][-1:]}


def _code() -> str:
    """One digest of every file of the packages that decide a trial."""
    found = hashlib.sha256()
    root = Path(validation.__file__).parent.parent
    for package in DECIDING:
        for path in sorted((root / package).rglob("*")):
            if path.is_file() and "__pycache__" not in path.parts:
                found.update(f"{path.relative_to(root)} {sha256_of(path)}\n".encode())
    return found.hexdigest()
