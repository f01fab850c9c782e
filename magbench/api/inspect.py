"""`magbench.inspect`."""

from __future__ import annotations

from collections.abc import Sequence
from os import PathLike
from pathlib import Path
from typing import TYPE_CHECKING

from magbench.api.inputs import Data, in_keywords, locked, path_of, reading_from, recording_from, reference_from
from scenarios.errors import InputError

if TYPE_CHECKING:
    from numpy.typing import ArrayLike

    from calib.reference import Reference
    from magbench.api.inspection_result import InspectionResult
    from recordings.reading import Reading
    from validation.inspection.inspection import Inspection


@in_keywords()
def inspect(
    data: Data,
    field_strength_nT: float | None = None,
    *,
    time_s: ArrayLike | None = None,
    maps: Sequence[str] = (),
    reading: Reading | None = None,
    run: int = 0,
    out: str | PathLike[str] | None = None,
) -> InspectionResult:
    """Report the contents of a recording, the calibrations it suffices for, and its faults; data as in `calibrate`.

    field_strength_nT : the Earth's field there, for the figures in the reasons; no status depends on it.
    out : directory for report.html and inspect.json. Raises InputError for data that cannot be read.

    >>> import magbench
    >>> import numpy as np
    >>> recording, truth = magbench.simulate("tumble", overrides=["phases.0.duration_s=60"])
    >>> strength_nT = float(np.linalg.norm(truth.field_nT[0]))
    >>> found = magbench.inspect(recording, strength_nT)
    >>> found
    recording: no warning, nothing to mend.
    >>> len(found.to_frame()) == len(found.findings)
    True
    """
    from magbench.api.inspection_result import InspectionResult

    with locked(out) as place:
        read = reading_from(data, maps, reading)
        found = _inspected(data, time_s, read, run, _reference(data, run, field_strength_nT, read))
        if place is not None:
            from reports.outputs.inspection import write_inspection

            write_inspection(found, place)
    return InspectionResult.of(found)


def _reference(data: Data, run: int, strength_nT: float | None, reading: Reading) -> Reference | None:
    """The reference of `calibrate`, None where nothing names the field and none is stated."""
    try:
        return reference_from(data, run, strength_nT, None, reading)
    except InputError:
        if strength_nT is not None:
            raise
        return None


def _inspected(
    data: Data, time_s: ArrayLike | None, reading: Reading, run: int, reference: Reference | None
) -> Inspection:
    from recordings import Recording
    from recordings.assemble import arrays_of
    from recordings.importer import RawColumns
    from recordings.memory import raw_columns_of
    from validation.inspection.inspection import inspect_file, inspect_log
    from validation.inspection.log import log_of

    if isinstance(data, str | PathLike):
        return inspect_file(path_of(data), reading=reading, run=run, reference=reference)
    if isinstance(data, Recording):
        raw = RawColumns(Path("recording"), arrays_of(recording_from(data)))
    else:
        raw = raw_columns_of(data, time_s=time_s, reading=reading)
    return inspect_log(log_of(raw), reference)
