"""`magbench.apply` and `magbench.apply_file`."""

from __future__ import annotations

from collections.abc import Sequence
from os import PathLike
from pathlib import Path
from typing import TYPE_CHECKING, Any

from magbench.api.inputs import Data, in_keywords, path_of, reading_from, recording_from
from scenarios.errors import InputError

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import ArrayLike, NDArray

    from calib.result import Calibration
    from recordings.reading import Reading


@in_keywords()
def apply(
    calibration: Calibration,
    data: Data,
    *,
    time_s: ArrayLike | None = None,
    maps: Sequence[str] = (),
    reading: Reading | None = None,
    run: int = 0,
) -> NDArray[np.float64]:
    """The field (n, 3) in nT, body frame, of a recording after correction; data as in `calibrate`.

    Of tolles_lawson the scalar magnetometer's strength (n,) without the vehicle's field.

    Raises InputError for a calibration without an estimate, and for rows that it cannot correct.

    >>> import magbench
    >>> import numpy as np
    >>> recording, truth = magbench.simulate("tumble", overrides=["phases.0.duration_s=60"])
    >>> strength_nT = float(np.linalg.norm(truth.field_nT[0]))
    >>> found = magbench.calibrate(recording, strength_nT)
    >>> raw_nT, field_nT = (np.linalg.norm(xyz, axis=1) for xyz in (recording.mag_nT, magbench.apply(found, recording)))
    >>> bool(abs(field_nT - strength_nT).mean() < abs(raw_nT - strength_nT).mean() / 10)
    True
    """
    from calib.result import Calibration
    from validation.calibrating.correction import corrected

    if not isinstance(calibration, Calibration):
        do = "pass one that magbench.calibrate returned; of several, one by its name"
        raise InputError(f"is of type {type(calibration).__name__}", where="calibration", do=do)
    read = reading_from(data, maps, reading)
    recording = recording_from(data, time_s=time_s, reading=read, run=run)
    return corrected(calibration, recording, calibration.name)


@in_keywords()
def apply_file(
    calibration: str | PathLike[str],
    data: str | PathLike[str],
    out: str | PathLike[str],
    *,
    name: str | None = None,
    run: int = 0,
    maps: Sequence[str] = (),
    reading: Reading | None = None,
    page: bool = False,
) -> dict[str, Any]:
    """Correct a file with one calibration of a calibration.json and write it to `out`, .parquet or .csv.

    name : of several calibrations. maps, reading : as in `calibrate`. page : also write a page with the strength before
    and after beside `out`, with the ending .html.
    Returns the calibrator, the number of samples, a warning where the calibration is not ok, the strength's mean and
    standard deviation before and after with the answer in words, and the page. Raises InputError for unusable files,
    for an `out` equal to its source, and for a page that would replace a file of another origin.

    >>> import magbench
    >>> made = magbench.simulate("tumble", "data", overrides=["phases.0.duration_s=60"])
    >>> found = magbench.calibrate("data", out="calibrated")
    >>> magbench.apply_file("calibrated/calibration.json", "data", "corrected.csv")["samples"]
    600
    """
    from reports.presentation.correction import PresentedCorrection
    from validation.calibrating.calibration_file import apply_file as corrected_file

    read = reading_from(data, maps, reading)
    place, log, place_out = path_of(calibration), path_of(data), Path(out)
    if page:
        from reports.outputs.correction import check_page, write_correction_page  # here: loads what draws

        check_page(place_out)
    applied = corrected_file(place, log, place_out, name=name, run=run, reading=read)
    shown = PresentedCorrection.of(applied, place, log, place_out)
    told = applied.summary() | {"strength": {name: one.summary() for name, one in shown.changes.items()}}
    told |= {"answer": shown.answer}
    return told | ({"page": str(write_correction_page(shown, applied))} if page else {})
