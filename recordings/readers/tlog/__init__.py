"""Telemetry logs of ground stations (.tlog): MAVLink frames of ArduPilot, PX4 and others, read by column."""

from __future__ import annotations

import datetime
from collections.abc import Mapping
from pathlib import Path

import numpy as np

from recordings.files import system_errors_about
from recordings.readers.base import FileContents, FileFormat, Wanted, library
from recordings.readers.tlog.channels import channel_streams
from recordings.readers.tlog.compasses import compasses_of, magnetometers_in
from recordings.readers.tlog.frames import EARLIEST_US, HEADS, LATEST_US, STAMP_BYTES, Frames, Sender, frames_of
from recordings.readers.tlog.quantities import fixes_of, places_of, streams_of
from recordings.readers.tlog.telemetry import Telemetry
from recordings.readers.utc import unix_date
from recordings.readers.vehicle_log import VehicleLog
from scenarios.errors import InputError

__all__ = ["TELEMETRY_LOG"]

DIALECT = "pymavlink.dialects.v20.ardupilotmega"
"""The library's messages: MAVLink's common ones, and ArduPilot's."""
AUTOPILOT_COMPONENT = 1
"""The number of the autopilot among the components of a system."""


def _recognises(path: Path, head: bytes) -> bool:
    """Whether a file begins with the time of a receiver and a frame."""
    stamp_us = int.from_bytes(head[:STAMP_BYTES], "big")
    return EARLIEST_US < stamp_us < LATEST_US and len(head) > STAMP_BYTES and head[STAMP_BYTES] in HEADS


def _read(path: Path, wanted: Wanted, stream: str | None) -> FileContents:
    messages = library(path, DIALECT, "ardupilot").mavlink_map
    with system_errors_about(path, "check the path and the permissions"):
        data = np.fromfile(path, np.uint8)
    with np.errstate(all="ignore"):  # damaged bytes may be any number
        frames, damaged = frames_of(data, messages)
        senders = {sender: Telemetry(types) for sender, types in frames.items()}
        if not senders:
            raise InputError("holds no whole message of MAVLink", where=str(path), do="copy the log again")
        return _vehicle_log(senders, damaged, wanted, stream).contents(path, wanted, stream)


def _vehicle_log(senders: Mapping[Sender, Telemetry], damaged: int, wanted: Wanted, stream: str | None) -> VehicleLog:
    sender = _vehicle(senders)
    log, notes = senders[sender], _about(senders, sender, damaged)
    fixes, compasses = fixes_of(log), compasses_of(log)
    streams, told = streams_of(log)
    chosen = compasses.get(stream or "", next(iter(compasses.values()), None))
    return VehicleLog(
        {name: one.stream for name, one in compasses.items()},
        streams | channel_streams(log, wanted),
        notes=(*(chosen.notes if chosen else ()), *told, *notes),
        frame="frd",
        place=_place(fixes) if fixes else None,
        date=_date(log),
        applied={name: one.applied for name, one in compasses.items() if one.applied is not None},
    )


def _vehicle(senders: Mapping[Sender, Telemetry]) -> Sender:
    """Return the sender with magnetometers, an autopilot before other components, of most samples."""
    counts = {one: sum(map(len, magnetometers_in(log).values())) for one, log in senders.items()}
    return max(counts, key=lambda one: (counts[one] > 0, one[1] == AUTOPILOT_COMPONENT, counts[one]))


def _about(senders: Mapping[Sender, Telemetry], vehicle: Sender, damaged: int) -> list[str]:
    """Return lines about other vehicles, and about frames with a wrong checksum."""
    others = [f"{s}.{c}" for s, c in senders if (s, c) != vehicle and magnetometers_in(senders[s, c])]
    notes = [f"sender {vehicle[0]}.{vehicle[1]} is read, not {', '.join(others)}"] if others else []
    sent = senders[vehicle].get("PARAM_VALUE")
    if sent is not None and (whole := int(np.max(sent.numbers("param_count")))) > len(set(sent.words("param_id"))):
        notes.append(f"{len(set(sent.words('param_id')))} of the autopilot's {whole} parameters are in the log")
    return notes + ([f"{damaged} frames left out: their checksum is wrong"] if damaged else [])


def _place(fixes: Frames) -> tuple[float, ...] | None:
    """Return the median of latitude and longitude, deg, and altitude, m; None where that is no place on Earth."""
    latitude, longitude, altitude = (float(x) for x in np.median(places_of(fixes), axis=0))
    return (latitude, longitude, altitude) if abs(latitude) <= 90 and abs(longitude) <= 180 else None


def _date(log: Telemetry) -> datetime.date | None:
    """Return the day (UTC) that the vehicle tells, else that of the receiver's clock."""
    told = log.get("SYSTEM_TIME")
    told_s = told.numbers("time_unix_usec") * 1e-6 if told is not None else np.zeros(0)
    stamps_s = np.concatenate([rows.stamps_s for rows in log.types.values()])
    return unix_date(float(np.median(told_s))) if told_s.any() else unix_date(float(np.median(stamps_s)))


TELEMETRY_LOG = FileFormat(
    name="MAVLink telemetry",
    suffixes=(".tlog",),
    summary="a ground station's telemetry log",
    extra="ardupilot",
    remark="ArduPilot's and PX4's calibration undone where the parameters are in the log",
    recognises=_recognises,
    read=_read,
)
