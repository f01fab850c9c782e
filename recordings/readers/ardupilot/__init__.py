"""ArduPilot's DataFlash logs, binary (.bin) and as text (.log), read by column."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from pathlib import Path

import numpy as np

from recordings.readers.ardupilot.channels import channel_streams
from recordings.readers.ardupilot.index import FMT_LENGTH, MARK
from recordings.readers.ardupilot.magnetometers import Compass, compasses_of
from recordings.readers.ardupilot.messages import Dataflash, read_dataflash
from recordings.readers.ardupilot.motion import attitude_stream, imu_stream, position_stream
from recordings.readers.ardupilot.parameters import Parameters
from recordings.readers.ardupilot.place import date_of, fixes_of, place_of, place_stream, start_of
from recordings.readers.ardupilot.power import command_streams, current_streams
from recordings.readers.ardupilot.text_log import is_text_log, read_text_log
from recordings.readers.ardupilot.vehicle import state_streams, vehicle_of
from recordings.readers.base import FileContents, FileFormat, Wanted
from recordings.readers.vehicle_log import VehicleLog
from recordings.streams import Stream

__all__ = ["ARDUPILOT_LOG", "ARDUPILOT_TEXT", "read_dataflash"]

STRAY_SHARE = 1e-3
"""Share of a log's bytes outside of messages from which the log counts as damaged."""
LAST_PAGE = 512
"""Bytes that the end of a sound log may have beyond its last message."""


def parameters_of(log: Dataflash) -> Parameters:
    """Return the parameters that a log tells, by its PARM messages."""
    rows = log.types.get("PARM")
    if rows is None or not ("Name" in rows and "Value" in rows):
        return Parameters()
    return Parameters(rows.words("Name"), log.times_s(rows), rows.numbers("Value"))


def _recognises(path: Path, head: bytes) -> bool:
    """Whether a file begins with a layout and a message, or holds these where its beginning was lost."""
    start = head.find(MARK)
    while start >= 0 and head[start + FMT_LENGTH : start + FMT_LENGTH + 2] != MARK[:2]:
        start = head.find(MARK, start + 1)
    return start >= 0


def _read(path: Path, wanted: Wanted, stream: str | None) -> FileContents:
    return _contents(path, read_dataflash, wanted, stream)


def _read_text(path: Path, wanted: Wanted, stream: str | None) -> FileContents:
    return _contents(path, read_text_log, wanted, stream)


def _contents(path: Path, read: Callable[[Path], Dataflash], wanted: Wanted, stream: str | None) -> FileContents:
    with np.errstate(all="ignore"):  # damaged bytes may be any number
        log = read(path)
        return _vehicle_log(log, wanted, stream).contents(path, wanted, stream)


def _vehicle_log(log: Dataflash, wanted: Wanted, stream: str | None) -> VehicleLog:
    parameters, fixes = parameters_of(log), fixes_of(log)
    compasses = compasses_of(log, parameters)
    streams, notes = own_streams(log, parameters, compasses)
    streams |= channel_streams(log, wanted, streams)
    chosen = compasses.get(stream or "", next(iter(compasses.values()), None))
    return VehicleLog(
        {name: one.stream for name, one in compasses.items()},
        streams,
        notes=(*(chosen.notes if chosen else ()), *notes, *_damage(log)),
        frame="frd",
        place=place_of(fixes) if fixes else None,
        date=date_of(fixes) if fixes else None,
        start_s=start_of(log, fixes) if fixes else None,
        applied={name: one.applied for name, one in compasses.items() if one.applied is not None},
    )


def own_streams(
    log: Dataflash, parameters: Parameters, compasses: Mapping[str, Compass]
) -> tuple[dict[str, Stream], list[str]]:
    """Return the streams of all quantities that a recording has names for, and notes."""
    vehicle = vehicle_of(log)
    times = [one.stream.times_s for one in compasses.values() if len(one.stream.times_s)]
    attitude, about_attitude = attitude_stream(log, parameters)
    currents, about_currents = current_streams(log)
    states, about_states = state_streams(log, vehicle, min((float(times_s[0]) for times_s in times), default=0.0))
    streams = imu_stream(log) | attitude | position_stream(log) | currents | states
    streams |= command_streams(log, parameters, vehicle) | place_stream(log)
    return streams, [*about_attitude, *about_currents, *about_states]


def _damage(log: Dataflash) -> list[str]:
    """Return a line where more than the end of a log is no message."""
    total = log.stray + sum(len(rows) * rows.layout.length for rows in log.types.values())
    if log.stray < max(STRAY_SHARE * total, LAST_PAGE):
        return []
    return [f"{log.stray} of {total} bytes are no message: the log is damaged or incomplete"]


ARDUPILOT_LOG = FileFormat(
    name="ArduPilot",
    suffixes=(".bin",),
    summary="an ArduPilot log",
    extra="ardupilot",
    remark="COMPASS_OFS, DIA, ODI, SCALE and the motors' term undone",
    recognises=_recognises,
    read=_read,
)

ARDUPILOT_TEXT = FileFormat(
    name="ArduPilot's log as text",
    suffixes=(".log",),
    summary="an ArduPilot log converted to text",
    remark="as of `.bin`",
    recognises=lambda path, head: is_text_log(head),
    read=_read_text,
)
