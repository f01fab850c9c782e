"""The kind of a vehicle, its flight modes as phases, and the armed state of a DataFlash log."""

from __future__ import annotations

import math
import re
from collections.abc import Iterable
from typing import Any

import numpy as np
from numpy.typing import NDArray

from recordings.channels import ARMED
from recordings.readers.ardupilot.messages import TEXTS, Dataflash, Messages
from recordings.streams import Interpolation, Stream
from scenarios.arrays import Array

COPTER, PLANE, ROVER, SUB, BLIMP = "copter", "plane", "rover", "sub", "blimp"
NO_MODE = "-"
"""In MODES: a number without a mode."""


def _numbered(names: str) -> dict[int, str]:
    return dict(enumerate(names.split()))


MODES: dict[str, dict[int, str]] = {
    COPTER: _numbered(
        "stabilize acro alt_hold auto guided loiter rtl circle position land of_loiter drift - sport flip autotune "
        "poshold brake throw avoid_adsb guided_nogps smart_rtl flowhold follow zigzag systemid autorotate auto_rtl "
        "turtle rate_acro"
    ),
    PLANE: _numbered(
        "manual circle stabilize training acro fbwa fbwb cruise autotune - auto rtl loiter takeoff avoid_adsb guided "
        "initialising qstabilize qhover qloiter qland qrtl qautotune qacro thermal loiteraltqland autoland"
    ),
    ROVER: _numbered(
        "manual acro learning steering hold loiter follow simple dock circle auto rtl smart_rtl - - guided initialising"
    ),
    SUB: _numbered(
        "stabilize acro alt_hold auto guided - - circle - surface - - - - - - poshold - - manual motordetect surftrak"
    ),
    BLIMP: _numbered("land manual velocity loiter rtl auto hold"),
}
"""By the kind of vehicle: the flight modes by their numbers [ArduPilot: mode.h of each vehicle]."""
_FIRMWARE = re.compile(rf"(?:ardu|apm:)?({'|'.join(MODES)})\s*v(\d{{1,3}})\.?(\d{{0,3}})", re.IGNORECASE)
ARM, DISARM = 10, 11
"""Numbers of the events of arming and disarming in EV messages."""


def vehicle_of(log: Dataflash) -> str:
    """Return the kind of vehicle that a log's messages of text tell, "" where they do not."""
    return firmware_of(log)[0]


def firmware_of(log: Dataflash) -> tuple[str, tuple[int, int]]:
    """Return the kind of vehicle and the release (major, minor) that a log's texts tell; "" and (0, 0) where none."""
    sources = [(log.types[name], field) for name, field in (("VER", "FWS"), ("MSG", "Message")) if name in log.types]
    return firmware_in([text for rows, field in sources if field in rows for text in rows.words(field)])


def firmware_in(texts: Iterable[str]) -> tuple[str, tuple[int, int]]:
    """Return the kind of vehicle and the release (major, minor) of the first text that tells; "" and (0, 0) of none."""
    found = next((match for text in texts if (match := _FIRMWARE.match(text))), None)
    return (found[1].lower(), (int(found[2]), int(found[3] or 0))) if found else ("", (0, 0))


def mode_name(vehicle: str, number: int) -> str:
    """Return the name of a flight mode, "mode 5" where the vehicle or the number is not known."""
    name = MODES.get(vehicle, {}).get(number, NO_MODE)
    return name if name != NO_MODE else f"mode {number}"


def _mode_names(rows: Messages, field: str, vehicle: str) -> list[str]:
    """Return the modes by their numbers, or as logs in text name them."""
    if rows.layout.kinds[field] in TEXTS:
        return [word.lower() or "mode" for word in rows.words(field)]
    return [mode_name(vehicle, int(number)) for number in rows.numbers(field)]


def state_streams(log: Dataflash, vehicle: str, start_s: float) -> tuple[dict[str, Stream], list[str]]:
    """Return the flight modes as phases and the armed state, from a time before the log's first sample on."""
    found, notes = {}, []
    rows = log.types.get("MODE")
    field = next((name for name in ("ModeNum", "Mode") if rows is not None and name in rows), None)
    if rows is not None and field:
        names = np.array(_mode_names(rows, field, vehicle))
        found["mode"] = events(log.times_s(rows), {"phase": names}, {"phase": names[0]}, start_s)
        unknown = sorted({name for name in names.tolist() if name.startswith("mode ")})
        notes = [f"flight modes without a known name: {', '.join(unknown)}"] if unknown else []
    times_s, armed = _armed(log)
    if len(armed):
        found["armed"] = events(times_s, {ARMED: armed}, {ARMED: 1.0 - armed[0]}, start_s)
    return found, notes


def events(times_s: Array, columns: dict[str, NDArray[Any]], first: dict[str, Any], start_s: float) -> Stream:
    """Return states that last until the next event, with the state before the first event from `start_s` on."""
    before = min(start_s, float(times_s[0])) - 1.0
    held = {name: np.concatenate([np.array([first[name]], values.dtype), values]) for name, values in columns.items()}
    how = dict.fromkeys(columns, Interpolation.HELD)
    return Stream(np.r_[before, times_s], held, how, max_gap_intervals=math.inf)


def _armed(log: Dataflash) -> tuple[Array, Array]:
    """Return the times of arming (1) and disarming (0)."""
    rows = log.types.get("ARM")
    if rows is not None and "ArmState" in rows:
        return log.times_s(rows), np.minimum(rows.numbers("ArmState"), 1.0)
    rows = log.types.get("EV")
    if rows is None or "Id" not in rows:
        return np.zeros(0), np.zeros(0)
    rows = rows.where(np.isin(rows.numbers("Id"), (ARM, DISARM)))
    return log.times_s(rows), (rows.numbers("Id") == ARM).astype(np.float64)
