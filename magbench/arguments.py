"""Arguments checked and completed before anything heavy is imported, by the names of files."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path

import scenarios
from scenarios.errors import InputError
from scenarios.names import closest, find, offered_calibrators, scenario_names

ROOT = Path(scenarios.__file__).parent.parent
ALL_PAPERS = "all"


def calibrator_names() -> list[str]:
    """Every calibrator: a file of its name in calib/methods."""
    return sorted(path.stem for path in (ROOT / "calib" / "methods").glob("[a-z]*.py"))


def paper_keys() -> list[str]:
    """Every paper that is reproduced: a folder of its key in papers."""
    return sorted(path.parent.name for path in (ROOT / "papers").glob("*/paper.py"))


def known_scenario(name: str | None) -> str | None:
    """A name of the catalogue or a file; raises InputError."""
    if name is not None:
        find(name)
    return name


def present(path: Path | None) -> Path | None:
    """An existing file or directory; raises InputError. Its contents are checked by its reader."""
    try:
        if path is not None:
            path.stat()
    except (FileNotFoundError, NotADirectoryError):
        raise InputError("no such file or directory", where=str(path), do="check the path") from None
    except (OSError, ValueError):
        pass
    return path


def all_present(paths: list[Path]) -> list[Path]:
    """Existing files and directories; raises InputError."""
    for path in paths:
        present(path)
    return paths


def known_calibrators(text: str | None) -> str | None:
    """Comma-separated names of calibrators; module:object is not checked here. Raises InputError."""
    if text is None:
        return None
    names, own = split(text), calibrator_names()
    if not names:
        raise InputError("names no calibrator", where="--with", do="see `magbench list calibrators`")
    others = [name for name in names if name not in own and ":" not in name]
    known = [*own, *offered_calibrators()] if others else own
    for name in others:
        if name not in known:
            do = closest(name, known, most=len(known))
            raise InputError(f"no calibrator is called {name!r}", where="--with", do=do)
    return text


def known_paper(key: str) -> str:
    """A paper's key in any case, or `all`; raises InputError."""
    known = [*paper_keys(), ALL_PAPERS]
    if key.lower() not in known:
        raise InputError(f"no paper {key!r}", where="KEY", do=f"choose among {', '.join(known)}")
    return key


def field_vector(text: str | None) -> tuple[float, float, float] | None:
    """Three numbers with commas between them, nT; raises InputError."""
    if text is None:
        return None
    try:
        east, north, up = (float(part) for part in text.split(","))
    except ValueError:
        do = "give three numbers: east,north,up in nT"
        raise InputError(f"{text!r} is not a field vector", where="--field-enu-nT", do=do) from None
    return east, north, up


def none_of(given: Mapping[str, object], what: str, do: str) -> None:
    """Options that say nothing here; InputError for the first that is given."""
    for option, value in given.items():
        if value is not None:
            raise InputError(what, where=option, do=do)


def split(text: str) -> list[str]:
    """The names in a list with commas."""
    return [name.strip() for name in text.split(",") if name.strip()]


def complete_scenario(incomplete: str) -> list[str]:
    """What the shell offers for SCENARIO; it completes files itself."""
    return _starting_with(incomplete, scenario_names())


def complete_calibrators(incomplete: str) -> list[str]:
    """What the shell offers for the last of a list with commas."""
    before, comma, last = incomplete.rpartition(",")
    return [before + comma + name for name in _starting_with(last, calibrator_names())]


def complete_paper(incomplete: str) -> list[str]:
    """What the shell offers for a paper's key."""
    return _starting_with(incomplete, [*paper_keys(), ALL_PAPERS])


def _starting_with(start: str, names: Sequence[str]) -> list[str]:
    return [name for name in names if name.startswith(start)]


def drawn_anew(overrides: Sequence[str], varied: Mapping[str, object]) -> str:
    """A line about values of --set that the scenario's [vary] draws anew for each run; "" for none."""
    keys = [key for key in (one.partition("=")[0].strip() for one in overrides) if key in varied]
    told = "[vary] of the scenario draws a value for each run, about or in place of this one"
    return f"--set {', '.join(keys)}: {told}" if keys else ""
