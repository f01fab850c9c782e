"""Phones: what Sensor Logger and phyphox export, an archive or a directory with one table a sensor, or JSON."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from recordings.channels import ALTITUDE, LATITUDE, LONGITUDE
from recordings.readers.base import HEAD_BYTES, FileContents, FileFormat, Wanted
from recordings.readers.navigation import median_place
from recordings.readers.packages import ZIP, TablePackage, archive, directory
from recordings.readers.phone_json import is_json_log, json_package
from recordings.readers.phone_tables import (
    GYROS,
    LOCATION,
    MAGNETOMETERS,
    SENSORS,
    PhoneTables,
    attitude,
    location,
    recorded_on,
    specific_force,
)
from recordings.readers.vehicle_log import VehicleLog, vector_columns
from recordings.streams import Stream
from scenarios.arrays import Array
from scenarios.errors import InputError

NAMES = {name for names in MAGNETOMETERS.values() for name in names}
"""Names of a magnetometer's table, in lower case without suffix."""
META = "meta"
"""phyphox' folder of what is no measurement."""
_AXES = "the phone's axes as logged are the body frame: x right, y up the screen, z out of the screen"
_UNDO = {
    "uncalibrated": "the magnetometer is without the phone's own calibration: nothing to be undone",
    "calibrated": "the magnetometer may have been calibrated by the phone: its bias is not logged, nothing was undone",
}


def _recognises(path: Path, head: bytes) -> bool:
    if is_json_log(head):
        return True
    try:
        package = _package(path) if head.startswith(ZIP) or _stands_beside(path) else None
    except InputError:
        return False
    return package is not None and _is_recording(package, head)


def _is_recording(package: TablePackage, head: bytes) -> bool:
    """Return whether tables are a phone's: a magnetometer's in an archive, beside another sensor's or phyphox' meta."""
    found = {name for folder in package.folders for name in package.tables(folder)}
    several = head.startswith(ZIP) or len(found & SENSORS) > 1 or META in package.folders
    return bool(found & NAMES) and several


def _stands_beside(path: Path) -> bool:
    """Return whether a file is a magnetometer's table, as directories of Sensor Logger and phyphox hold."""
    return path.suffix.lower() == ".csv" and path.stem.lower() in NAMES


def _package(path: Path) -> TablePackage:
    with path.open("rb") as file:
        head = file.read(HEAD_BYTES)
    if is_json_log(head):
        return json_package(path)
    return directory(path.parent, META) if _stands_beside(path) else archive(path)


def _read(path: Path, wanted: Wanted, stream: str | None) -> FileContents:
    """Return the uncalibrated magnetometer, or the calibrated, with the other sensors at its times."""
    package = _package(path)
    package.check_size()
    folder = package.folder_of(NAMES)
    phone = PhoneTables(package, package.tables(folder), package.tables(f"{folder}/{META}".lstrip("/")))
    fields = {name: phone.vectors("mag", *names) for name, names in MAGNETOMETERS.items()}
    sensors = {
        name: Stream(found[0], vector_columns("mag", found[1])) for name, found in fields.items() if found is not None
    }
    if not sensors:
        what = "holds no table with times and x, y, z of a magnetometer"
        raise InputError(what, where=str(path), do="record the magnetometer, and export it as CSV")
    streams = _streams(phone)
    fixes = streams[LOCATION].columns if LOCATION in streams else {}
    place = median_place(fixes[LATITUDE], fixes[LONGITUDE], _median(fixes.get(ALTITUDE))) if fixes else None
    main = next((name for name in sensors if stream and name == stream.lower()), next(iter(sensors)))
    notes = (_AXES, _UNDO[main], *phone.notes)
    log = VehicleLog(sensors, streams, notes, place=place, date=recorded_on(phone))
    return log.contents(path, wanted, stream)


def _median(values: Array | None) -> float:
    """Return the median of finite values, 0 without any."""
    known = np.array([]) if values is None else values[np.isfinite(values)]
    return float(np.median(known)) if len(known) else 0.0


def _streams(phone: PhoneTables) -> dict[str, Stream]:
    """Return gyro, specific force, orientation and fixes, as far as recorded."""
    rate, force = phone.vectors("gyro", *GYROS), specific_force(phone)
    found = {"gyro": rate, "accel": force}
    own = {name: Stream(one[0], vector_columns(name, one[1])) for name, one in found.items() if one is not None}
    return {**own, **attitude(phone, force), **location(phone)}


PHONE = FileFormat(
    name="phone recording",
    suffixes=(".zip", ".json"),
    summary="what Sensor Logger or phyphox exports",
    remark="Sensor Logger (JSON too), phyphox; the uncalibrated sensor is taken",
    recognises=_recognises,
    read=_read,
    markers=("[Mm]agnetometer*.csv", "[Mm]agnetic [Ff]ield.csv", "[Rr]aw [Dd]ata.csv"),
)
