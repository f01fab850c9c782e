"""Arguments of the public functions as recordings, references, scenarios and calibrators."""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from contextvars import ContextVar
from os import PathLike
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeAlias

from magbench.arguments import present
from scenarios.errors import InputError

if TYPE_CHECKING:
    from numpy.typing import ArrayLike, NDArray

    from calib.reference import Reference
    from recordings import Recording
    from recordings.memory import Frame
    from recordings.reading import Reading
    from sim.pool import Tasks
    from sim.scenario import Scenario
    from validation.bound.limit import Tilts
    from validation.calibrating.calibrator_entry import CalibratorEntry
    from validation.comparison.engine import Engine

Data: TypeAlias = (
    "Recording | Frame | NDArray[Any] | Sequence[Sequence[float]] | Mapping[str, ArrayLike] | str | PathLike[str]"
)
"""A recording; a data frame or a dict with columns time_s and mag_x_nT …; an array (n, 3) in nT; a file's path."""
Warn = Callable[[str], object]
"""Called with a line about something amiss."""
Progress: TypeAlias = Callable[[float, int], object]
"""Called with (pieces done, pieces in all)."""
OPTION = re.compile(r"--([a-zA-Z][\w-]*)")
KEYWORDS = {
    **{"map": "maps", "with": "with_", "exec": "exec_", "actuator": "actuators"},
    **{"time": "time_s", "set": "overrides", "export": "exports"},
}
"""Options whose keyword has another name."""
_options_named: ContextVar[bool] = ContextVar("options_named", default=False)


def quiet(*told: object) -> None:
    """Take what is told and do nothing."""


@contextmanager
def in_options() -> Iterator[None]:
    """Within, InputErrors of public functions name the options of the command line."""
    token = _options_named.set(True)
    try:
        yield
    finally:
        _options_named.reset(token)


@contextmanager
def in_keywords() -> Iterator[None]:
    """Within, InputErrors name the keyword in place of the option, unless `in_options` is in force."""

    def keyword(option: re.Match[str]) -> str:
        return KEYWORDS.get(option[1], option[1].replace("-", "_"))

    try:
        yield
    except InputError as error:
        if _options_named.get():
            raise
        what, where, do = (OPTION.sub(keyword, text) for text in (error.what, error.where, error.do))
        raise InputError(what, where=where, do=do) from None


def reading_from(data: object, maps: Sequence[str], reading: Reading | None) -> Reading:
    """How data are read: as stated, else as kept beside a file."""
    from recordings.reading import Reading

    if isinstance(data, str | PathLike):
        return Reading.for_file(path_of(data), maps, reading)
    return Reading.of(maps, reading)


def recording_from(
    data: object, *, time_s: ArrayLike | None = None, reading: Reading | None = None, run: int = 0
) -> Recording:
    """A Recording as it is, a file read, an array or data frame taken in; InputError for anything else."""
    from recordings import Recording, read_recording
    from recordings.memory import recording_in_memory

    if isinstance(data, Recording):
        _check_shape(data)
        return data
    if isinstance(data, str | PathLike):
        return read_recording(path_of(data), run=run, reading=reading)
    return recording_in_memory(data, time_s=time_s, reading=reading)


def path_of(data: str | PathLike[str]) -> Path:
    """The path of an existing file or directory."""
    path = Path(data)
    present(path)
    return path


def reference_from(
    data: object,
    run: int,
    field_strength_nT: float | None,
    field_enu_nT: Sequence[float] | None,
    reading: Reading | None = None,
    recording: Recording | None = None,
) -> Reference:
    """The stated reference, that of place and date, else a simulated run's own; InputError for none.

    recording : as it was read; it may tell place and date, or the calibration in force.
    """
    from recordings.manifest import file_of
    from validation.calibrating.reference import reference_of, stated_reference, told_field

    stated = stated_field(field_strength_nT, field_enu_nT, reading)
    strength, vector = stated if recording is None else told_field(*stated, recording.origin, recording.mag_nT)
    if isinstance(data, str | PathLike):
        return reference_of(file_of(path_of(data), run), strength, vector)
    return stated_reference("reference", strength, vector)


def recording_and_reference(
    data: object,
    field: tuple[float | None, Sequence[float] | None],
    time_s: ArrayLike | None = None,
    reading: Reading | None = None,
    run: int = 0,
) -> tuple[Recording, Reference]:
    """The recording, and the reference of a stated strength and vector; see `reference_from`."""
    recording = recording_from(data, time_s=time_s, reading=reading, run=run)
    return recording, reference_from(data, run, *field, reading, recording)


def stated_field(
    field_strength_nT: float | None, field_enu_nT: Sequence[float] | None, reading: Reading | None = None
) -> tuple[float | None, list[float] | None]:
    """The stated strength and vector as numbers, else the vector of place and date; InputError for anything else."""
    from validation.calibrating.reference import field_at

    if field_strength_nT is None and field_enu_nT is None and reading is not None:
        return None, field_at(reading.place, reading.date)
    strength = None if field_strength_nT is None else _number("--field-strength-nT", field_strength_nT)
    vector = None if field_enu_nT is None else _numbers("--field-enu-nT", field_enu_nT)
    return strength, vector


def scenario_from(scenario: str | PathLike[str] | Scenario, overrides: Sequence[str]) -> Scenario:
    """A scenario by its name or file, with overrides, or as it is; InputError for an unknown one."""
    from sim.scenario import Scenario, load

    if not isinstance(scenario, Scenario):
        return load(scenario if isinstance(scenario, str) else Path(scenario), overrides)
    if overrides:
        do = "pass them to magbench.load"
        raise InputError("a scenario that is loaded takes no overrides", where="--set", do=do)
    return scenario


def calibrators_from(
    with_: str | Sequence[str], exec_: Sequence[str], time_limit_s: float | None, otherwise: Sequence[str] = ()
) -> tuple[CalibratorEntry, ...]:
    """The named calibrators and programs; where neither is given those of `otherwise`; InputError for unknown ones."""
    from validation.calibrating.processes import TIME_LIMIT_S
    from validation.calibrating.selection import calibrators_of_scenario, select_calibrators

    names = [with_] if isinstance(with_, str) else list(with_)
    if otherwise and not (names or exec_):
        return calibrators_of_scenario(otherwise, time_limit_s or TIME_LIMIT_S)
    if not (names or exec_):
        raise InputError("names no calibrator", where="--with", do="see `magbench list calibrators`")
    return select_calibrators(names, exec_, time_limit_s or TIME_LIMIT_S)


@contextmanager
def locked(out: str | PathLike[str] | None) -> Iterator[Path | None]:
    """The output directory, held by this process and without leftovers; None where nothing is to be written."""
    from recordings.files import locked_directory, remove_leftovers

    if out is None:
        yield None
        return
    with locked_directory(Path(out)):
        remove_leftovers(Path(out))
        yield Path(out)


@contextmanager
def place_for(out: str | PathLike[str] | None) -> Iterator[Path]:
    """The output directory, or a temporary one where nothing is to be kept."""
    from tempfile import TemporaryDirectory

    if out is not None:
        yield Path(out)
        return
    with TemporaryDirectory(prefix="magbench-") as place:
        yield Path(place)


def tilts_from(limits: tuple[float, float] | str | None) -> Tilts | None:
    """Limits of roll and pitch, degrees, as two numbers or `ROLL,PITCH`; InputError for anything else."""
    from validation.bound.limit import Tilts

    if limits is None:
        return None
    return Tilts.parsed(limits, "--tilt-limits") if isinstance(limits, str) else Tilts.checked(*limits, "--tilt-limits")


def engine(scheduler: str | None, jobs: int | None) -> Engine:
    """The engine that computes trials: a Dask cluster, processes of this machine, or without `jobs` this process."""
    from validation.comparison.engine import ProcessEngine, SerialEngine

    if scheduler:
        from validation.comparison.cluster import Cluster

        return Cluster(scheduler)
    return SerialEngine() if jobs is None else ProcessEngine(jobs)


def tasks_on(scheduler: str | None) -> Tasks | None:
    """A Dask cluster for any tasks, None without one."""
    if not scheduler:
        return None
    from validation.comparison.cluster import Cluster

    return Cluster(scheduler)


def check_count(option: str, value: int | None, least: int = 1) -> None:
    """Raise InputError for a count below the least one; None is the default."""
    if value is not None and value < least:
        raise InputError(f"{value} is too few", where=option, do=f"give {least} or more")


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
