"""`magbench.read`."""

from __future__ import annotations

from collections.abc import Sequence
from os import PathLike
from pathlib import Path
from typing import TYPE_CHECKING

from magbench.api.inputs import in_keywords, path_of, reading_from
from scenarios.errors import InputError

if TYPE_CHECKING:
    from magbench.api.log_result import LogResult
    from recordings import Recording
    from recordings.reading import Reading


@in_keywords()
def read(
    log: str | PathLike[str],
    *,
    out: str | PathLike[str] | None = None,
    maps: Sequence[str] = (),
    reading: Reading | None = None,
) -> LogResult:
    """Read a log of any format into a recording, and tell what was found and what was done to the columns.

    log : an autopilot's log, a table of text, a bag of ROS, ...: `magbench.recordings.FORMATS`.
    out : a .parquet or .csv file for the recording; Parquet keeps place, date and the calibration in force.
    maps, reading : as in `calibrate`. Raises InputError for a log that cannot be read, and for an `out` that would
    replace the log.

    >>> import magbench
    >>> from pathlib import Path
    >>> rows = [f"{0.1 * k:.1f},{20 + k % 2},{k},{43 - k % 3}" for k in range(20)]
    >>> size = Path("log.csv").write_text("\\n".join(["time_s,mag_x_uT,mag_y_uT,mag_z_uT", *rows]))
    >>> found = magbench.read("log.csv")
    >>> len(found.recording), found.recording.mag_nT[0].tolist()
    (20, [20000.0, 0.0, 43000.0])
    """
    from magbench.api.log_result import LogResult
    from recordings import read_recording, write_recording
    from recordings.readers import format_of, marked_file

    path = path_of(log)
    if out is not None and Path(out).exists() and Path(out).samefile(path):
        raise InputError("would replace the log", where=str(out), do="write to another file")
    recording = read_recording(path, reading=reading_from(log, maps, reading))
    found = LogResult(path, format_of(marked_file(path)).name, recording, _field(recording))
    if out is not None:
        write_recording(recording, Path(out))
    return found


def _field(recording: Recording) -> tuple[float, float, float] | None:
    """The world model's field at the place and date of a recording; None where they are not both known."""
    from validation.calibrating.reference import field_at

    origin = recording.origin
    if origin.place is None or origin.date is None:
        return None
    found = field_at(origin.place, origin.date)
    assert found is not None
    return found[0], found[1], found[2]
