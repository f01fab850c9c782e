"""The functions for notebooks and scripts: typed for editors, and each imports what it needs when it is called."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, TypeVar, overload

from magbench.inputs import in_keywords, path_of, recording_from, reference_from, scenario_from
from scenarios.errors import InputError

Method = TypeVar("Method")

if TYPE_CHECKING:
    from collections.abc import Callable, Mapping
    from os import PathLike
    from pathlib import Path
    from typing import Any

    import numpy as np
    from numpy.typing import ArrayLike, NDArray

    from calib.result import Calibration
    from diagnosis.policy import Policy
    from magbench.results import CalibrationResult, DiagnosisResult, InspectionResult, RunResult
    from recordings import Recording, Truth
    from recordings.memory import Frame
    from sim.scenario import Scenario

    Data = Recording | Frame | NDArray[Any] | Sequence[Sequence[float]] | Mapping[str, ArrayLike] | str | PathLike[str]
    """A recording; a data frame or a dict with columns time_s and mag_x_nT …; an array (n, 3) in nT; a file's path."""


@overload
def calibrate(
    data: Data,
    field_strength_nT: float | None = None,
    *,
    with_: str = "ellipsoid",
    field_enu_nT: Sequence[float] | None = None,
    time_s: ArrayLike | None = None,
    maps: Sequence[str] = (),
    run: int = 0,
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
    run: int = 0,
) -> dict[str, CalibrationResult]: ...


@in_keywords()
def calibrate(
    data: Data,
    field_strength_nT: float | None = None,
    *,
    with_: str | list[str] | tuple[str, ...] = "ellipsoid",
    field_enu_nT: Sequence[float] | None = None,
    time_s: ArrayLike | None = None,
    maps: Sequence[str] = (),
    run: int = 0,
) -> CalibrationResult | dict[str, CalibrationResult]:
    """Fit m = S h + b to a recording by one calibrator, or by several: then by name, in a dict.

    data : a Recording; an array (n, 3) in nT, body frame; a data frame, or a dict, with columns time_s and mag_x_nT …;
        or the path of a log, a run or a dataset directory.
    field_strength_nT, field_enu_nT : the Earth's field there, its strength or (east, north, up); a simulated run's
        file knows its own.
    with_ : names of `magbench list calibrators`, what `magbench.register` named, or module:object. A fit that failed
        is a result too: its `status` says why.
    time_s : (n,) beside an array; without it the samples are taken to be a second apart.
    maps : `mag_x_nT=bx,unit=uT` renames and converts columns. run : which run of a dataset directory.

    Raises InputError for data that are not fit for use, an unknown calibrator, and a reference that is not known.
    """
    from magbench.results import CalibrationResult
    from validation.calibrating.fitting import fit_all, sensor_recordings
    from validation.calibrating.selection import select_calibrators

    names = [with_] if isinstance(with_, str) else list(with_ or ())
    if not names:
        raise InputError("names no calibrator", where="with_", do="see `magbench list calibrators`")
    chosen = select_calibrators(names)
    recording = recording_from(data, time_s=time_s, maps=maps, run=run)
    reference = reference_from(data, run, field_strength_nT, field_enu_nT)
    fitted = fit_all(recording, reference, chosen)
    views = {key: one for candidate in chosen for key, one in sensor_recordings(recording, candidate.name).items()}
    results = {key: CalibrationResult.of(found, views[key], reference) for key, found in fitted.items()}
    if not isinstance(with_, str):
        return results
    if len(results) != 1:
        what = "the recording is of an array of sensors, each with its calibration"
        raise InputError(what, where="with_", do=f'pass a list: with_=["{with_}"] gives {", ".join(results)}')
    return next(iter(results.values()))


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

    What is to run in other processes too, or may hang or crash, is better named by module:object.
    Raises InputError for what is no calibrator, and for a name of magbench's own.
    """
    from validation.calibrating import registry

    if found is None:
        return lambda later: register(later, name=name)
    registry.register(found, name)
    return found


@in_keywords()
def apply(
    calibration: Calibration,
    data: Data,
    *,
    time_s: ArrayLike | None = None,
    maps: Sequence[str] = (),
    run: int = 0,
) -> NDArray[np.float64]:
    """The field (n, 3) in nT, body frame, of a recording after correction; data as in `calibrate`.

    Raises InputError for a calibration without an estimate, and for rows that it cannot correct.
    """
    from calib.result import Calibration
    from validation.calibrating.correction import corrected_field

    if not isinstance(calibration, Calibration):
        do = "pass one that magbench.calibrate returned; of several, one by its name"
        raise InputError(f"is of type {type(calibration).__name__}", where="calibration", do=do)
    return corrected_field(calibration, recording_from(data, time_s=time_s, maps=maps, run=run), calibration.name)


@in_keywords()
def inspect(data: Data, *, time_s: ArrayLike | None = None, maps: Sequence[str] = (), run: int = 0) -> InspectionResult:
    """Tell what a recording holds, what it is fit for and what is odd; data as in `calibrate`."""
    from os import PathLike
    from pathlib import Path

    from magbench.results import InspectionResult
    from recordings import Recording
    from recordings.assemble import arrays_of
    from recordings.importer import RawColumns
    from recordings.memory import raw_columns_of
    from validation.inspection.inspection import inspect_file, inspect_log
    from validation.inspection.log import log_of

    if isinstance(data, str | PathLike):
        return InspectionResult.of(inspect_file(path_of(data), maps=maps, run=run))
    if isinstance(data, Recording):
        raw = RawColumns(Path("recording"), arrays_of(recording_from(data)))
    else:
        raw = raw_columns_of(data, time_s=time_s, maps=maps)
    return InspectionResult.of(inspect_log(log_of(raw, maps)))


@in_keywords()
def diagnose(
    data: Data,
    model: str | Path | None = None,
    *,
    field_strength_nT: float | None = None,
    field_enu_nT: Sequence[float] | None = None,
    confirm: Data | None = None,
    time_s: ArrayLike | None = None,
    policy: Policy | None = None,
    actuators: Sequence[str] = (),
    maps: Sequence[str] = (),
    run: int = 0,
    sensor: int | None = None,
    reference_sensor: int | None = None,
) -> DiagnosisResult:
    """Find where a recording and a model disagree, and name the missing effect; data and reference as in `calibrate`.

    model : a scenario's name, or a file of it or of its [field] and [effects.*] alone; without it hard iron, soft iron
        and white noise, fitted. confirm : a second recording, in which the finding must hold too. actuators : channels
        to treat like motor currents. time_s : (n,) of `data`, where that is an array. policy : the numbers that decide.
        sensor : which of an array of sensors, counted from 1. reference_sensor : the one whose reading is the field.
    """
    from functools import partial
    from pathlib import Path

    from diagnosis.policy import STANDARD
    from diagnosis.problem.actuators import with_actuators
    from diagnosis.problem.array_sensor import one_sensor
    from diagnosis.single import diagnose_against
    from magbench.results import DiagnosisResult

    def read(one: Data, times: ArrayLike | None) -> Recording:
        recording, place = recording_from(one, time_s=times, maps=maps, run=run), Path("recording")
        return with_actuators(one_sensor(recording, sensor, reference_sensor, place), actuators, place)

    found = diagnose_against(
        model,
        partial(read, data, time_s),
        partial(reference_from, data, run, field_strength_nT, field_enu_nT),
        stated=field_strength_nT is not None or field_enu_nT is not None,
        confirm=None if confirm is None else partial(read, confirm, None),
        sensor=sensor,
        policy=policy or STANDARD,
    )
    return DiagnosisResult.of(found)


@in_keywords()
def simulate(
    scenario: str | Path | Scenario, *, overrides: Sequence[str] = (), seed: int | None = None
) -> tuple[Recording, Truth]:
    """One run of a scenario, by name, file or `magbench.load`: what the instrument gives, and the truth beside it.

    overrides : `effects.white_noise.std_nT=[5,5,5]` and the like. `magbench.generate` writes many runs to files.
    """
    from pathlib import Path
    from tempfile import TemporaryDirectory

    from recordings import read_run
    from sim.dataset_writer import generate

    with TemporaryDirectory(prefix="magbench-") as place:
        generate(scenario_from(scenario, overrides), Path(place), seed=seed)
        return read_run(Path(place))


@in_keywords()
def run(
    scenario: str | Path | Scenario,
    out: str | PathLike[str] | None = None,
    *,
    with_: Sequence[str] = (),
    overrides: Sequence[str] = (),
    seed: int | None = None,
) -> RunResult:
    """Simulate a scenario, calibrate, and score against the truth; with `out` write report and recording there.

    with_ : who calibrates, as in `calibrate`; by default the scenario's calibrators.
    """
    from pathlib import Path
    from tempfile import TemporaryDirectory

    from magbench.results import RunResult
    from reports.outputs.run import run_scenario, simulate_and_score
    from validation.calibrating.selection import select_calibrators

    spec = scenario_from(scenario, overrides)
    chosen = select_calibrators([with_] if isinstance(with_, str) else with_ or spec.calibrators)
    if out is not None:
        return RunResult.of(run_scenario(spec, Path(out), seed=seed, chosen=chosen))
    with TemporaryDirectory(prefix="magbench-") as place:
        return RunResult.of(simulate_and_score(spec, Path(place), seed, chosen))
