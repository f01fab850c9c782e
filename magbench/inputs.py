"""What a caller hands over, as recordings and references; messages speak of arguments, not of options."""

from __future__ import annotations

import re
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from os import PathLike
from pathlib import Path
from typing import TYPE_CHECKING

from magbench.arguments import present
from scenarios.errors import InputError

if TYPE_CHECKING:
    from numpy.typing import ArrayLike

    from calib.reference import Reference
    from recordings import Recording
    from sim.scenario import Scenario

OPTION = re.compile(r"--([a-zA-Z][\w-]*)")
KEYWORDS = {"map": "maps", "with": "with_", "actuator": "actuators", "time": "time_s"}
"""Options whose keyword has another name."""


@contextmanager
def in_keywords() -> Iterator[None]:
    """InputErrors from within name the keyword where they would name an option of the command line."""

    def keyword(option: re.Match[str]) -> str:
        return KEYWORDS.get(option[1], option[1].replace("-", "_"))

    try:
        yield
    except InputError as error:
        what, where, do = (OPTION.sub(keyword, text) for text in (error.what, error.where, error.do))
        raise InputError(what, where=where, do=do) from None


def recording_from(
    data: object, *, time_s: ArrayLike | None = None, maps: Sequence[str] = (), run: int = 0
) -> Recording:
    """A Recording as it is, a file read, an array or data frame taken in; InputError for anything else."""
    from recordings import Recording, read_recording
    from recordings.memory import recording_in_memory

    if isinstance(data, Recording):
        _check_shape(data)
        return data
    if isinstance(data, str | PathLike):
        return read_recording(path_of(data), run=run, maps=maps)
    return recording_in_memory(data, time_s=time_s, maps=maps)


def path_of(data: str | PathLike[str]) -> Path:
    """The path of a file or directory that is there."""
    path = Path(data)
    present(path)
    return path


def reference_from(
    data: object, run: int, field_strength_nT: float | None, field_enu_nT: Sequence[float] | None
) -> Reference:
    """The stated reference, else the field that a simulated run's file names; InputError for none."""
    from recordings.manifest import file_of
    from validation.calibrating.reference import reference_of, stated_reference

    strength = None if field_strength_nT is None else _number("field_strength_nT", field_strength_nT)
    vector = None if field_enu_nT is None else _numbers("field_enu_nT", field_enu_nT)
    if isinstance(data, str | PathLike):
        return reference_of(file_of(path_of(data), run), strength, vector)
    return stated_reference("reference", strength, vector)


def scenario_from(scenario: str | PathLike[str] | Scenario, overrides: Sequence[str]) -> Scenario:
    """A scenario by its name or file, with overrides, or as it is; InputError for one that is not there."""
    from sim.scenario import Scenario, load

    if not isinstance(scenario, Scenario):
        return load(scenario if isinstance(scenario, str) else Path(scenario), overrides)
    if overrides:
        do = "pass them to magbench.load"
        raise InputError("a scenario that is loaded takes no overrides", where="overrides", do=do)
    return scenario


def _number(where: str, value: object) -> float:
    try:
        return float(value)  # type: ignore[arg-type]
    except (TypeError, ValueError):
        raise InputError(f"{value!r} is not a number", where=where, do="give it in nT") from None


def _numbers(where: str, values: object) -> list[float]:
    if isinstance(values, str) or not hasattr(values, "__iter__"):
        raise InputError(f"{values!r} is not a field vector", where=where, do="give east, north and up in nT")
    return [_number(where, value) for value in values]


def _check_shape(recording: Recording) -> None:
    import numpy as np

    shapes = np.shape(recording.time_s), np.shape(recording.mag_nT)
    if len(shapes[0]) != 1 or shapes[1] != (*shapes[0], 3):
        what = f"time_s has shape {shapes[0]} and mag_nT {shapes[1]}"
        raise InputError(what, where="recording", do="give (n,) times and (n, 3) fields")
