"""The words by which a calibrator is asked for again: in another process, in a file of gates."""

from __future__ import annotations

import os
import shlex
from collections.abc import Mapping
from dataclasses import asdict, dataclass
from typing import Any, Self

from validation.calibrating.calibrator_entry import BuiltIn, CalibratorEntry
from validation.calibrating.external_command import PLACEHOLDER, ExternalCommand
from validation.calibrating.python_object import ImportedObject, default_name


@dataclass(frozen=True)
class Invocation:
    """What `--with` takes, or of a program its name, and its words with their placeholders.

    time_limit_s : of a fit; None for one of magbench's own. needs : what a program is said to need of a recording.
    """

    calibrator: str
    words: tuple[str, ...] = ()
    time_limit_s: float | None = None
    needs: tuple[str, ...] = ()

    @classmethod
    def of(cls, found: CalibratorEntry) -> Self | None:
        """None for an object in memory, which no words name."""
        match found.method:
            case BuiltIn(name):
                return cls(name)
            case ImportedObject(name, spec, time_limit_s):
                return cls(spec if name == default_name(spec) else f"{name}={spec}", time_limit_s=time_limit_s)
            case ExternalCommand(name, words, time_limit_s, needs=needs):
                return cls(name, words, time_limit_s, needs)
        return None

    def plain(self) -> dict[str, Any]:
        """As JSON has it, which `read` takes."""
        return asdict(self)

    @classmethod
    def read(cls, plain: Mapping[str, Any]) -> Self:
        """From plain values; a comparison of an earlier magbench says no needs."""
        return cls(plain["calibrator"], tuple(plain["words"]), plain["time_limit_s"], tuple(plain.get("needs", ())))

    @property
    def exec(self) -> str:
        """A program's command; what lies below this directory is seen from here, so that it moves with it."""
        return " ".join(_quoted(_from_here(word)) for word in self.words)


def _from_here(word: str) -> str:
    here = os.path.join(os.getcwd(), "")
    return f".{os.sep}{word.removeprefix(here)}" if word.startswith(here) else word


def _quoted(word: str) -> str:
    """As a shell wants it, but for a placeholder's braces, which no `exec` minds."""
    bare = PLACEHOLDER.sub("x", word)
    return word if shlex.quote(bare) == bare else shlex.quote(word)
