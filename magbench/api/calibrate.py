"""`magbench.calibrate` and `magbench.register`."""

from __future__ import annotations

from collections.abc import Sequence
from os import PathLike
from typing import TYPE_CHECKING, TypeVar, overload

from magbench.api.inputs import (
    Data,
    calibrators_from,
    in_keywords,
    locked,
    path_of,
    reading_from,
    recording_and_reference,
)
from scenarios.errors import InputError

Method = TypeVar("Method")

if TYPE_CHECKING:
    from collections.abc import Callable
    from pathlib import Path

    from numpy.typing import ArrayLike

    from calib.reference import Reference
    from magbench.api.calibration_results import CalibrationResult, Calibrations
    from recordings import Recording
    from recordings.reading import Reading
    from validation.calibrating.base_station import WithoutChange
    from validation.calibrating.output_unit import OutputUnit


@overload
def calibrate(
    data: Data,
    field_strength_nT: float | None = None,
    *,
    with_: str = "ellipsoid",
    field_enu_nT: Sequence[float] | None = None,
    time_s: ArrayLike | None = None,
    maps: Sequence[str] = (),
    reading: Reading | None = None,
    run: int = 0,
    time_limit_s: float | None = None,
    out: str | PathLike[str] | None = None,
    exports: Sequence[str] = (),
    force: bool = False,
    unit_out: str | None = None,
    base: str | PathLike[str] | None = None,
    base_start: str | None = None,
    tolerance_deg: float | None = None,
) -> CalibrationResult: ...


@overload
def calibrate(
    data: Data,
    field_strength_nT: float | None = None,
    *,
    with_: list[str] | tuple[str, ...],
    field_enu_nT: Sequence[float] | None = None,
    time_s: ArrayLike | None = None,
    maps: Sequence[str] = (),
    reading: Reading | None = None,
    run: int = 0,
    exec_: Sequence[str] = (),
    time_limit_s: float | None = None,
    out: str | PathLike[str] | None = None,
    exports: Sequence[str] = (),
    force: bool = False,
    unit_out: str | None = None,
    base: str | PathLike[str] | None = None,
    base_start: str | None = None,
    tolerance_deg: float | None = None,
) -> Calibrations: ...


@in_keywords()
def calibrate(
    data: Data,
    field_strength_nT: float | None = None,
    *,
    with_: str | list[str] | tuple[str, ...] = "ellipsoid",
    field_enu_nT: Sequence[float] | None = None,
    time_s: ArrayLike | None = None,
    maps: Sequence[str] = (),
    reading: Reading | None = None,
    run: int = 0,
    exec_: Sequence[str] = (),
    time_limit_s: float | None = None,
    out: str | PathLike[str] | None = None,
    exports: Sequence[str] = (),
    force: bool = False,
    unit_out: str | None = None,
    base: str | PathLike[str] | None = None,
    base_start: str | None = None,
    tolerance_deg: float | None = None,
) -> CalibrationResult | Calibrations:
    """Fit m = S h + b to a recording by one calibrator, or by several: then by name, in a dict.

    data : a Recording; an array (n, 3) in nT, body frame; a data frame, or a dict, with columns time_s and mag_x_nT …;
        or the path of a log, a run or a dataset directory.
    field_strength_nT, field_enu_nT : the Earth's field there, its strength or (east, north, up); a simulated run's
        file knows its own.
    with_ : names of `magbench list calibrators`, what `magbench.register` named, or module:object. A failed fit is a
        result too: its `status` says why. An empty list: sphere and ellipsoid, planar for a level turn, and
        motor_ellipsoid where currents, throttle or temperature were logged and vary.
    time_s : (n,) beside an array; without it the samples are taken to be a second apart.
    maps : `mag_x_nT=bx,unit=uT` renames and converts columns. reading : a `magbench.Reading`: columns, unit, axes,
        frame, place and date of a log. run : which run of a dataset directory.
    exec_ : programs that calibrate, beside a list of names. time_limit_s : of one fit outside magbench.
    out : directory for report.html, calibration.json and the `exports` (c, px4, ardupilot, ros): of every calibrator
        that was named, else of the recommended one.
    force : export estimates too whose status is not ok, with the status in a comment.
    unit_out : a unit for offset and matrix of the C header and of a further file: uT, mG, ..., `counts=NT_A_COUNT`, or
        `counts` and `log` as the maps or the reading state.
    base : the record of a base station or an observatory (IAGA-2002), whose change in the day is taken off first.
        base_start : UTC at the log's time 0, such as "2024-05-01T12:30:00", where the log tells no time of day.
    tolerance_deg : heading error on a level survey; `assessment.tolerance` answers whether it is below.

    Raises InputError for data that are not fit for use, an unknown calibrator, a reference that is not known, and
    for a refused export, after all other files are written.

    >>> import magbench
    >>> import numpy as np
    >>> recording, truth = magbench.simulate("tumble", overrides=["phases.0.duration_s=60"])
    >>> strength_nT = float(np.linalg.norm(truth.field_nT[0]))
    >>> found = magbench.calibrate(recording, strength_nT, with_=["ellipsoid", "sphere"])
    >>> {name: one.status.kind for name, one in found.items()}
    {'ellipsoid': 'ok', 'sphere': 'unobservable'}
    >>> found["ellipsoid"].offset_nT.shape
    (3,)
    """
    from magbench.api.calibration_results import Calibrations

    forms = _forms(exports, out)
    chosen = calibrators_from(with_, exec_, time_limit_s) if with_ or exec_ else ()
    with locked(out) as place:
        read = reading_from(data, maps, reading)
        known = recording_and_reference(data, (field_strength_nT, field_enu_nT), time_s, read, run)
        results = Calibrations.of(*known, chosen, _quiet(known[1], base, base_start))
        results.tolerance_deg, results.unit = _tolerance(tolerance_deg), _unit(unit_out, read)
        _write(results, place, forms, force, data)
    return _chosen(results, with_, exec_)


def _quiet(
    reference: Reference, base: str | PathLike[str] | None, base_start: str | None
) -> Callable[[Recording], WithoutChange] | None:
    """What takes the day's change off a recording; None without a base station."""
    from validation.calibrating.base_station import BaseStation, without_change

    if base is None:
        if base_start is not None:
            raise InputError("is the time of a log beside a base station", where="--base-start", do="add --base FILE")
        return None
    station = BaseStation.read(path_of(base))
    return lambda recording: without_change(recording, reference, station, base_start)


def _chosen(
    results: Calibrations, with_: str | list[str] | tuple[str, ...], exec_: Sequence[str]
) -> CalibrationResult | Calibrations:
    """The one calibration where a single name was given, else all."""
    return results if exec_ or not isinstance(with_, str) else _single(results, with_)


def _unit(unit_out: str | None, read: Reading) -> OutputUnit | None:
    """The unit of further files; None without one."""
    from validation.calibrating.output_unit import output_unit

    return output_unit(unit_out, read) if unit_out else None


def _tolerance(tolerance_deg: float | None) -> float | None:
    """The tolerance; InputError for none above zero."""
    if tolerance_deg is not None and not tolerance_deg > 0:
        raise InputError(f"{tolerance_deg:g} is no tolerance", where="--tolerance-deg", do="give degrees above 0")
    return tolerance_deg


def _forms(exports: Sequence[str], out: str | PathLike[str] | None) -> tuple[str, ...]:
    """The formats of the exports; InputError for an unknown one, and without a directory."""
    from validation.calibrating.export import known_forms

    if exports and out is None:
        raise InputError("exports need a directory", where="--export", do="add -o DIRECTORY")
    return known_forms(",".join(exports)) if exports else ()


def _write(results: Calibrations, place: Path | None, forms: Sequence[str], force: bool, data: Data) -> None:
    """Write calibration.json, exports and page; InputError for refused exports, after all other files are written."""
    if place is None:
        return
    from reports.outputs.calibration import write_calibration_page
    from validation.calibrating.calibration_file import RefusedExportsError, write_calibrations

    applied, only = results.recording.origin.applied, results.exported
    written = write_calibrations(results, place, forms, force=force, unit=results.unit, applied=applied, only=only)
    told = (*written.files, *(f"not exported: {line}" for line in written.refused))
    shown = results.presented(path_of(data).name if isinstance(data, str | PathLike) else "recording")
    write_calibration_page(shown, results, results.recording, results.reference, place, told)
    if written.refused:
        raise RefusedExportsError(written.refused, results)


def _single(results: Calibrations, name: str) -> CalibrationResult:
    """The one calibration; InputError for an array's several."""
    if len(results) == 1:
        return next(iter(results.values()))
    what = "the recording is of an array of sensors, each with its calibration"
    raise InputError(what, where="--with", do=f'pass a list: with_=["{name}"] gives {", ".join(results)}')


@overload
def register(found: Method, *, name: str | None = None) -> Method: ...


@overload
def register(*, name: str) -> Callable[[Method], Method]: ...


@in_keywords()
def register(found: Method | None = None, *, name: str | None = None) -> Method | Callable[[Method], Method]:
    """Make a calibrator of your own known by a name: for `calibrate`, `run` and scenarios, in this process.

    found : a `magbench.Calibrator` (class or instance), or a function of (recording, reference) that returns
        (offset_nT, matrix), a dict with the keys of calibration.json, or a `magbench.Calibration`.
    name : by default the object's own. `@magbench.register` and `@magbench.register(name="mine")` are decorators.

    A calibrator that is to run in other processes, or may hang or crash, is better named by module:object.
    Raises InputError for an object that is no calibrator, and for a name of magbench's own.

    >>> import magbench
    >>> import numpy as np
    >>> @magbench.register(name="middle")
    ... def middle(recording, reference):
    ...     return (recording.mag_nT.max(axis=0) + recording.mag_nT.min(axis=0)) / 2, np.eye(3)
    >>> around_nT = 48_000 * np.tile(np.vstack([np.eye(3), -np.eye(3)]), (5, 1))
    >>> magbench.calibrate(around_nT + [10, 20, 30], 48_000, with_="middle").offset_nT.tolist()
    [10.0, 20.0, 30.0]
    """
    from validation.calibrating import registry

    if found is None:
        return lambda later: register(later, name=name)
    registry.register(found, name)
    return found
