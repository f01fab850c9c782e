"""PX4's logs (.ulg) as recordings."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

import numpy as np

from recordings.readers.base import FileContents, FileFormat, Wanted
from recordings.readers.px4.channels import channel_streams
from recordings.readers.px4.contents import MissingUlogFieldError, ULog
from recordings.readers.px4.magnetometers import magnetometers
from recordings.readers.px4.motion import motion_streams
from recordings.readers.px4.place import place_and_date, start_of
from recordings.readers.px4.power import power_streams
from recordings.readers.px4.ulog import MAGIC, read_ulog
from recordings.readers.vehicle_log import VehicleLog
from scenarios.errors import InputError

ENCRYPTED = (b"ULogKey", b"ULogEnc")
"""The first bytes of logs that PX4 encrypted, and of their keys."""
ENCRYPTED_SUFFIXES = (".ulgc", ".ulge")


def _recognises(path: Path, head: bytes) -> bool:
    return head.startswith((MAGIC, *ENCRYPTED)) or path.suffix.lower() in ENCRYPTED_SUFFIXES


def _read(path: Path, wanted: Wanted, stream: str | None) -> FileContents:
    """Return the columns at the times of one magnetometer, its calibration undone."""
    with path.open("rb") as file:
        head = file.read(len(MAGIC))
    if head in ENCRYPTED or (head != MAGIC and path.suffix.lower() in ENCRYPTED_SUFFIXES):
        raise InputError("is a log that PX4 encrypted", where=str(path), do="decrypt it, and give the .ulg file")
    try:
        with np.errstate(all="ignore"):  # damaged numbers may be of any size
            return _contents(path, wanted, stream)
    except MissingUlogFieldError as error:
        raise InputError(str(error), where=str(path), do="copy the log again, or give another") from error


def _contents(path: Path, wanted: Wanted, stream: str | None) -> FileContents:
    log = read_ulog(path)
    found = magnetometers(log)
    if not found:
        do = "log it (SDLOG_PROFILE), or give another log"
        raise InputError("holds no samples of a magnetometer", where=str(path), do=do)
    chosen = next((one for one in found if stream and one.name == stream.lower()), found[0])
    motion, moved, read = motion_streams(log, chosen.sensor)
    power, powered, used = power_streams(log)
    others, beyond = channel_streams(log, used | read, wanted, len(chosen.stream.times_s))
    place, date = place_and_date(log)
    vehicle = VehicleLog(
        {one.name: one.stream for one in found},
        others | power | motion,
        (*_about(log), *chosen.notes, *_about_columns(moved | powered, wanted), *([beyond] if beyond else [])),
        frame="frd",
        place=place,
        date=date,
        start_s=start_of(log),
        applied={one.name: one.applied for one in found},
    )
    return vehicle.contents(path, wanted, stream)


def _about_columns(notes: Mapping[str, str], wanted: Wanted) -> list[str]:
    """Return the notes of wanted columns, by column; an empty note says nothing."""
    return [note for name, note in notes.items() if note and wanted(name)]


def _about(log: ULog) -> list[str]:
    """Return notes of the release and of damage."""
    notes = [f"PX4 {log.release}"] if log.release else []
    if log.damaged:
        notes.append(f"{log.damaged} damaged bytes skipped")
    return [*notes, "the log is cut off: the last message is incomplete"] if log.cut else notes


PX4 = FileFormat(
    name="ULog",
    suffixes=(".ulg",),
    summary="a PX4 log",
    remark="PX4's CAL_MAG, the power compensation and the learned bias undone, of every release",
    recognises=_recognises,
    read=_read,
)
