"""Names of scenarios and calibrators: the catalogue's files, and the nearest valid name for a misspelt name."""

from __future__ import annotations

from collections.abc import Iterable
from pathlib import Path

from scenarios.errors import InputError

CATALOGUE = Path(__file__).parent / "catalogue"
CALIBRATORS_GROUP = "magbench.calibrators"
"""The group of entry points by which installed packages offer calibrators."""


def scenario_names() -> list[str]:
    """Return every name of the catalogue."""
    return sorted(path.stem for path in CATALOGUE.glob("*.toml"))


def find(name_or_path: str | Path) -> Path:
    """Return the file of a catalogue name or path; InputError, listing the names, for an unknown name."""
    named = CATALOGUE / f"{name_or_path}.toml"
    if "/" not in str(name_or_path) and named.is_file():
        return named
    if Path(name_or_path).exists():
        return Path(name_or_path)
    names = scenario_names()
    do = "give a TOML file or a name of the catalogue; " + closest(str(name_or_path), names, most=len(names))
    raise InputError("no such file, and no scenario of this name", where=str(name_or_path), do=do)


def offered_calibrators() -> dict[str, str]:
    """Return the calibrators of installed packages: module:object by name."""
    from importlib.metadata import entry_points

    return {one.name: f"{one.module}:{one.attr}" for one in entry_points(group=CALIBRATORS_GROUP)}


def closest(word: str, valid: Iterable[str], most: int = 8) -> str:
    """Return advice with the valid words nearest to an invalid word."""
    from difflib import get_close_matches

    words = sorted(valid)
    near = get_close_matches(word, words, n=3, cutoff=0.5)
    if near:
        return "did you mean " + " or ".join(near) + "?"
    more = ", ..." if len(words) > most else ""
    return "valid: " + ", ".join(words[:most]) + more if words else "there is none to name"
