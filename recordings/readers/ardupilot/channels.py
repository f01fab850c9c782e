"""Every other number of a DataFlash log, as channels under the log's own names: `BAT.CurrTot`, `IMU[1].GyrX`."""

from __future__ import annotations

import re
from collections.abc import Callable, Mapping

import numpy as np

from recordings.readers.ardupilot.messages import CLOCKS, INSTANCES, TEXTS, Dataflash, Messages
from recordings.readers.ardupilot.power import sources_of
from recordings.streams import Interpolation, Stream

OF_THE_LOG = {"FMT", "FMTU", "UNIT", "MULT", "PARM", "MSG", "FILE", "VER", "ISBH", "ISBD", "CMD", "MAG", "MAG2", "MAG3"}
"""Messages about the log, and of the compasses."""
ESTIMATES = re.compile(r"XK\w\w?|NK\w\w?|EKF\d|AHR2|ATT|ANG|POS|DCM|EAHR|NTUN|ORGN|XKF\w|NKF\w")
"""Messages that a filter computes from the compasses themselves: no causes of what the compasses measure."""
CODES = "BbM"
"""Format characters of states and flags, which last until the next sample."""
FEWEST = 3
"""Messages of which a channel is made."""
OWN = {
    "inertial unit": r"IMU\.((Gyr|Acc)[XYZ]|T|Temp)",
    "barometer": r"BARO\.Temp",
    "battery current": r"(BAT|CURR)\.Curr",
    "battery voltage": r"(BAT|CURR)\.Volt",
    "throttle": r"CTUN\.(ThO|ThrOut)",
    "fixes": r"GPS\.(Lat|Lng|Alt|GWk|GMS|Week|TimeMS|T)",
    "mode": r"MODE\.(Mode|ModeNum)",
    "armed": r"ARM\.ArmState|EV\.Id",
}
"""By the name of a stream: the values, of the first instance, that the recording has under names of its own."""
Wanted = Callable[[str], bool]


def channel_streams(log: Dataflash, wanted: Wanted, streams: Mapping[str, Stream]) -> dict[str, Stream]:
    """Return a stream for each type and instance with wanted channels, beside the other streams."""
    own = re.compile("|".join(pattern for name, pattern in OWN.items() if name in streams) or "(?!)")
    taken = {source for name in streams for source in sources_of(name)}
    found: dict[str, Stream] = {}
    for name in sorted(log.types.keys() - OF_THE_LOG):
        if not ESTIMATES.fullmatch(name):
            found |= _of_type(log, name, lambda channel: wanted(channel) and channel not in taken, own)
    return found


def _of_type(log: Dataflash, name: str, wanted: Wanted, own: re.Pattern[str]) -> dict[str, Stream]:
    instances = log.types[name].instances()
    found = {}
    for number, rows in instances.items():
        label = f"{name}[{number}]" if len(instances) > 1 else name
        hidden = {field for field in _fields(rows) if number == min(instances) and own.fullmatch(f"{name}.{field}")}
        fields = {field: f"{label}.{field}" for field in _fields(rows) if field not in hidden}
        fields = {field: channel for field, channel in fields.items() if wanted(channel)}
        if fields and len(rows) >= FEWEST:
            found[label] = _stream(log, rows, fields)
    return found


def _fields(rows: Messages) -> list[str]:
    """Return the names of the values that are single numbers, but for times and the instance."""
    kinds = rows.layout.kinds.items()
    return [name for name, kind in kinds if kind not in TEXTS + "a" and name not in CLOCKS and name not in INSTANCES]


def _stream(log: Dataflash, rows: Messages, fields: dict[str, str]) -> Stream:
    columns = {channel: rows.numbers(field) for field, channel in fields.items()}
    finite = {channel: np.where(np.isfinite(values), values, np.nan) for channel, values in columns.items()}
    held = {channel: Interpolation.HELD for field, channel in fields.items() if rows.layout.kinds[field] in CODES}
    return Stream(log.times_s(rows), finite, held)
