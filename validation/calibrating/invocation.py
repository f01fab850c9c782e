"""How a calibrator is named on a command line or in a gate file, stored with a comparison."""

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
    """The `--with` text of a calibrator; of a program the name, and the words with placeholders.

    time_limit_s : of one fit, None for a built-in calibrator. needs : signals that a program is declared to need.
    """

    calibrator: str
    words: tuple[str, ...] = ()
    time_limit_s: float | None = None
    needs: tuple[str, ...] = ()

    @classmethod
    def of(cls, entry: CalibratorEntry) -> Self | None:
        """Return the invocation of an entry; None for an object in memory, which has no name elsewhere."""
        match entry.method:
            case BuiltIn(name):
                return cls(name)
            case ImportedObject(name, spec, time_limit_s):
                return cls(spec if name == default_name(spec) else f"{name}={spec}", time_limit_s=time_limit_s)
            case ExternalCommand(name, words, time_limit_s, needs=needs):
                return cls(name, words, time_limit_s, needs)
        return None

    def plain(self) -> dict[str, Any]:
        """Return plain values for JSON, accepted by `read`."""
        return asdict(self)

    @classmethod
    def read(cls, plain: Mapping[str, Any]) -> Self:
        """Build from plain values; `needs` is missing in comparisons of earlier versions."""
        return cls(plain["calibrator"], tuple(plain["words"]), plain["time_limit_s"], tuple(plain.get("needs", ())))

    @property
    def exec(self) -> str:
        """The command of a program; paths below the working directory are written relative to the directory."""
        return " ".join(_quoted(_relative(word)) for word in self.words)


def _relative(word: str) -> str:
    here = os.path.join(os.getcwd(), "")
    return f".{os.sep}{word.removeprefix(here)}" if word.startswith(here) else word


def _quoted(word: str) -> str:
    """Quote a word for a shell; braces of placeholders need no quotes in `exec`."""
    bare = PLACEHOLDER.sub("x", word)
    return word if shlex.quote(bare) == bare else shlex.quote(word)
