"""A Seaglider's dive as the basestation writes it: one netCDF file a dive, the compass' magnetometer in counts."""

from __future__ import annotations

import math
from collections.abc import Mapping

import numpy as np

from recordings.body_frame import flu_from_frd
from recordings.channels import HEIGHT, LATITUDE, LONGITUDE, TEMPERATURE
from recordings.columns import ATTITUDE, POSITION, group_of
from recordings.readers.navigation import east_north_m, enu_of_angles, median_place
from recordings.readers.netcdf_file import NetcdfFile, middle_day
from recordings.readers.vehicle_log import VehicleLog, vector_columns
from recordings.reading import COUNT
from recordings.streams import Interpolation, Stream
from scenarios.arrays import Array

COUNTS = ("eng_mag_x", "eng_mag_y", "eng_mag_z")
"""The magnetometer, forward, right, down; [basestation3] Magcal.py turns y and z likewise."""
ANGLES = ("eng_rollAng", "eng_pitchAng", "eng_head")
"""Roll, right side down, and pitch, nose up, from accelerometers; the compass' magnetic heading. In degrees."""
MASSES = ("gc_pitch_ad", "gc_roll_ad", "gc_vbd_ad")
"""Positions of the moving masses and of the buoyancy engine, A/D counts, at the end of each motion."""
BEGIN, END = "gc_st_secs", "gc_end_secs"
_NOTES = (
    "a Seaglider's dive: y and z of the magnetometer and the attitude turned from forward, right, down",
    "the magnetometer is in raw counts: the glider's own calibration acts on the heading alone, nothing to undo",
    "the attitude takes its heading from this same magnetometer: no independent reference of the heading",
    "temperature_degC is the sea's: the compass' is not logged",
)


def is_seaglider(file: NetcdfFile) -> bool:
    """Return whether a file is a dive with the magnetometer's counts at the times of the other samples."""
    times = file.seconds("time")
    return times is not None and all(
        name in file.variables and file.variables[name].values.shape == times.shape for name in COUNTS
    )


def seaglider_log(file: NetcdfFile) -> VehicleLog:
    """Return the dive of a file that `is_seaglider`."""
    times = _times(file, "time")
    counts = np.column_stack([file.variables[name].values for name in COUNTS])
    attitude, turn = _attitude(file, times)
    own = {"attitude": attitude, "depth": _depth(file, times), **_masses(file, times)}
    found = {**own, **_position(file), **_water(file)}
    streams: dict[str, Stream] = {name: stream for name, stream in found.items() if stream is not None}
    taken = {column for stream in streams.values() for column in stream.columns}
    others = {f"of {name}": one for name, one in _channels(file, taken).items()}
    latitude, longitude = (_values(file, name) for name in ("log_gps_lat", "log_gps_lon"))
    return VehicleLog(
        {"compass": Stream(times, vector_columns("mag", flu_from_frd(counts)))},
        {**streams, **others},
        notes=(*_NOTES, *turn),
        frame="frd",
        unit=COUNT,
        place=None if latitude is None or longitude is None else median_place(latitude, longitude),
        date=middle_day(times),
    )


def _times(file: NetcdfFile, name: str) -> Array:
    found = file.seconds(name)
    return np.array([]) if found is None else found


def _values(file: NetcdfFile, name: str, times: Array | None = None) -> Array | None:
    """Return a variable (n,); None where absent, or of another length than its times."""
    variable = file.variables.get(name)
    if variable is None or variable.values.ndim != 1:
        return None
    return variable.values if times is None or variable.values.shape == times.shape else None


def _attitude(file: NetcdfFile, times: Array) -> tuple[Stream | None, tuple[str, ...]]:
    """Return the attitude, true heading = magnetic heading + variation, and notes on what was added."""
    angles = [_values(file, name, times) for name in ANGLES]
    found = [angle for angle in angles if angle is not None]
    if len(found) < len(ANGLES):
        return None, ()
    added = [file.number(name) or 0.0 for name in ("sg_cal_rollbias", "sg_cal_pitchbias", "magnetic_variation")]
    signs = (-1.0, -1.0, 1.0)
    roll, pitch, yaw = (np.radians(a + sign * b) for a, sign, b in zip(found, signs, added, strict=True))
    told = zip(
        ("roll's bias {} deg subtracted", "pitch's bias {} deg subtracted", "declination {} deg added to the heading"),
        added,
        strict=True,
    )
    columns = vector_columns("attitude", enu_of_angles(roll, pitch, yaw))
    how = dict.fromkeys(ATTITUDE, Interpolation.SLERP)
    return Stream(times, columns, how), tuple(text.format(f"{value:g}") for text, value in told if value)


def _depth(file: NetcdfFile, times: Array) -> Stream | None:
    depth_m = _values(file, "depth", times)
    return None if depth_m is None else Stream(times, {HEIGHT: -depth_m}, max_gap_intervals=math.inf)


def _position(file: NetcdfFile) -> dict[str, Stream | None]:
    """Return the estimated track below the surface at the times of the CTD, east and north of its begin."""
    times = _times(file, "ctd_time")
    latitude, longitude = (_values(file, name, times) for name in ("latitude", "longitude"))
    if latitude is None or longitude is None or not len(times):
        return {}
    named = zip(POSITION[:2], east_north_m(latitude, longitude), strict=True)
    columns = {**dict(named), LATITUDE: latitude, LONGITUDE: longitude}
    return {"track": Stream(times, columns, max_gap_intervals=math.inf)}


def _water(file: NetcdfFile) -> dict[str, Stream | None]:
    times = _times(file, "ctd_time")
    celsius = _values(file, "temperature", times)
    if celsius is None or not len(times):
        return {}
    return {"water": Stream(times, {TEMPERATURE: celsius}, max_gap_intervals=math.inf)}


def _masses(file: NetcdfFile, times: Array) -> dict[str, Stream | None]:
    """Return the masses' positions: linear between begin and end of a motion, constant before, between and after."""
    begin, end = _times(file, BEGIN), _times(file, END)
    found: dict[str, Stream | None] = {}
    for name in MASSES:
        last, first = _values(file, name, end), _values(file, f"{name}_start", begin)
        if last is not None and first is not None and begin.shape == end.shape and len(begin):
            at = np.r_[times[:1] - 1, np.column_stack([begin, end]).ravel(), times[-1:] + 1]
            positions = np.r_[first[:1], np.column_stack([first, last]).ravel(), last[-1:]]
            found[name] = Stream(at, {name: positions}, max_gap_intervals=math.inf)
    return found


def _channels(file: NetcdfFile, taken: set[str]) -> Mapping[str, Stream]:
    """Return every other variable along a dimension with times, one stream a dimension."""
    clocks: dict[tuple[str, ...], str] = {}
    for name, variable in file.variables.items():
        if variable.since is not None and variable.values.ndim == 1:
            clocks.setdefault(variable.dimensions, name)
    columns: dict[str, dict[str, Array]] = {}
    for name, variable in file.variables.items():
        clock = clocks.get(variable.dimensions)
        if clock is not None and variable.since is None and _is_channel(name, taken):
            columns.setdefault(clock, {})[name] = variable.values
    return {clock: Stream(_times(file, clock), own) for clock, own in columns.items()}


def _is_channel(name: str, taken: set[str]) -> bool:
    """Return whether a variable is neither read already, nor a motion's, nor a fix's at the surface."""
    return name not in (*taken, *COUNTS) and group_of(name) == "channel" and not name.startswith(("gc_", "log_"))
