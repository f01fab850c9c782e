"""`magbench.bound` and `magbench.what_if`."""

from __future__ import annotations

from collections.abc import Sequence
from os import PathLike
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal

from magbench.api.inputs import (
    Data,
    in_keywords,
    reading_from,
    recording_and_reference,
    scenario_from,
    tilts_from,
)
from scenarios.errors import InputError

if TYPE_CHECKING:
    from magbench.api.planning_results import BoundResult, WhatIfResult
    from recordings.reading import Reading
    from sim.scenario import Scenario
    from validation.bound.experiment import Experiment
    from validation.bound.query import BoundAnswer, BoundQuery

Knowledge = Literal["norm", "norm+gyro", "norm+gyro+accel", "vector", "vector+eddy"]


@in_keywords()
def bound(
    source: Scenario | Data,
    knowledge: Knowledge = "norm",
    *,
    field_strength_nT: float | None = None,
    field_enu_nT: Sequence[float] | None = None,
    noise_std_nT: float | None = None,
    gyro_noise_rad_s: float | None = None,
    gyro_scale_std: float = 0.0,
    strength_unknown: bool = False,
    coloured: bool = False,
    tilt_limits: tuple[float, float] | str | None = None,
    overrides: Sequence[str] = (),
    maps: Sequence[str] = (),
    reading: Reading | None = None,
    run: int = 0,
    out: str | PathLike[str] | None = None,
) -> BoundResult:
    """The least errors that any method can reach with a scenario or a recording, and what is not observable.

    source : a scenario by name, TOML file or `magbench.load`; else data as in `calibrate`, with its reference.
    knowledge : what a method knows of the field. noise_std_nT, gyro_noise_rad_s : white noise; default: as found.
    gyro_scale_std : standard deviation of the gyro's scale, a fraction. strength_unknown : S only up to a factor.
    coloured, overrides : of a scenario: with its flicker noise and random walk; values changed.
    tilt_limits : roll and pitch, degrees: the best of all motions within them is computed too.
    out : directory for report.html and bound.json.

    Raises InputError for an unusable source, and for knowledge without its data.

    >>> import magbench
    >>> found = magbench.bound("tumble", noise_std_nT=10)
    >>> found.bound.offset_std_nT.shape, len(found.weak)
    ((3,), 0)
    >>> list(found.to_frame().columns[:2])
    ['offset_std_nT', 'S_x_std']
    """
    from sim.scenario import Scenario

    noise = noise_std_nT, gyro_noise_rad_s, gyro_scale_std
    query = _query(knowledge, *noise, strength_unknown, coloured=coloured, tilts=tilt_limits)
    if isinstance(source, Scenario | str | PathLike) and is_scenario(source):
        spec = scenario_from(source, overrides)
        return _written(query.of_scenario(spec), spec.name, out)
    if coloured or overrides:
        what = "applies to a scenario, and this is a recording"
        raise InputError(what, where="--coloured, --set", do="leave it out")
    read = reading_from(source, maps, reading)
    field = field_strength_nT, field_enu_nT
    title = Path(source).name if isinstance(source, str | PathLike) else "recording"
    return _written(query.answer(_experiment(source, read, run, field, noise_std_nT)), title, out)


def _written(found: BoundAnswer, title: str, out: str | PathLike[str] | None) -> BoundResult:
    """The result, with page and numbers in `out` if there is one."""
    from magbench.api.planning_results import BoundResult
    from reports.outputs.bound import write_bound

    if out is not None:
        write_bound(found, title, Path(out))
    return BoundResult.of(found)


def _experiment(
    source: Scenario | Data,
    reading: Reading,
    run: int,
    field: tuple[float | None, Sequence[float] | None],
    noise_std_nT: float | None,
) -> Experiment:
    """The experiment of a recording; field : the stated strength and vector."""
    from validation.bound.files import experiment_of

    where = str(source) if isinstance(source, str | PathLike) else "recording"
    recording, reference = recording_and_reference(source, field, reading=reading, run=run)
    return experiment_of(recording.in_nT(where), reference, noise_std_nT, where)


@in_keywords()
def what_if(
    scenario: str | Path | Scenario,
    values: str,
    knowledge: Knowledge = "norm",
    *,
    noise_std_nT: float | None = None,
    gyro_noise_rad_s: float | None = None,
    gyro_scale_std: float = 0.0,
    strength_unknown: bool = False,
    coloured: bool = False,
    tilt_limits: tuple[float, float] | str | None = None,
    overrides: Sequence[str] = (),
    out: str | PathLike[str] | None = None,
) -> WhatIfResult:
    """The bound of a scenario at several values of one of its keys; the other arguments as in `bound`.

    values : `roll_amplitude_deg=0:30:5` or `KEY=A,B,C`. out : directory for report.html and bound.json.

    Raises InputError for a key that the scenario does not have, and for values that the vehicle cannot fly.

    >>> import magbench
    >>> found = magbench.what_if("tumble", "noise_std_nT=1,2")
    >>> once, twice = (one.bound.offset_rms_nT for one in found.answers)
    >>> round(twice / once, 3)
    2.0
    """
    from magbench.api.displayed import values_of
    from magbench.api.planning_results import WhatIfResult
    from reports.outputs.bound import write_what_if
    from scenarios.sweep import parse_sweep
    from validation.bound.query import OPTION, WhatIf

    noise = noise_std_nT, gyro_noise_rad_s, gyro_scale_std
    query = _query(knowledge, *noise, strength_unknown, coloured=coloured, tilts=tilt_limits)
    spec = scenario_from(scenario, overrides)
    found = WhatIf.of(query, spec, parse_sweep(values, spec, OPTION))
    if out is not None:
        write_what_if(found, spec.name, Path(out))
    return WhatIfResult(**values_of(found))


def _query(
    knowledge: str,
    noise_std_nT: float | None,
    gyro_std_rad_s: float | None,
    gyro_scale_std: float,
    strength_unknown: bool,
    *,
    coloured: bool,
    tilts: Any,
) -> BoundQuery:
    from validation.bound.knowledge import KNOWLEDGE
    from validation.bound.query import BoundQuery

    if knowledge not in KNOWLEDGE:
        raise InputError(f"{knowledge!r} is not known", where="--knowledge", do=f"one of {', '.join(KNOWLEDGE)}")
    limits = tilts_from(tilts)
    return BoundQuery(knowledge, not strength_unknown, noise_std_nT, gyro_std_rad_s, limits, coloured, gyro_scale_std)


def is_scenario(source: object) -> bool:
    """Whether an argument names or is a scenario rather than data; InputError for a path that does not exist."""
    from scenarios.names import find
    from sim.scenario import Scenario

    if isinstance(source, str | PathLike):
        return find(Path(source) if isinstance(source, PathLike) else source).suffix == ".toml"
    return isinstance(source, Scenario)
