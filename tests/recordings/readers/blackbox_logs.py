"""Blackbox logs as a test writes them: predictions and encodings as in the sources of Betaflight and INAV."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np

from scenarios.arrays import Array

START = "H Product:Blackbox flight data recorder by Nicholas Sherlock"
ZERO, PREVIOUS, LINE, AVERAGE, MIN_THROTTLE, MOTOR_0, INCREMENT, HOME, FIXED, VBAT, MAIN_TIME, MIN_MOTOR = range(12)
SVB, UVB, NEG_14BIT, TAG8_8SVB, TAG2_3S32, TAG8_4S16, NOTHING, TAG2_3SVARIABLE = 0, 1, 3, 6, 7, 8, 9, 10


@dataclass(frozen=True)
class Field:
    """A field: name, sign, predictor and encoding of I frames, and of P frames."""

    name: str
    signed: bool
    first: tuple[int, int]
    further: tuple[int, int] = (ZERO, NOTHING)


def vector(name: str, first: tuple[int, int], further: tuple[int, int], count: int = 3) -> list[Field]:
    """Return fields name[0], name[1], ..."""
    return [Field(f"{name}[{k}]", True, first, further) for k in range(count)]


def betaflight_fields() -> list[Field]:
    """The main fields of Betaflight 4.5 that tests need, in its order."""
    average = ((ZERO, SVB), (AVERAGE, SVB))
    return [
        Field("loopIteration", False, (ZERO, UVB), (INCREMENT, NOTHING)),
        Field("time", False, (ZERO, UVB), (LINE, SVB)),
        *vector("axisI", (ZERO, SVB), (PREVIOUS, TAG2_3S32)),
        *vector("rcCommand", (ZERO, SVB), (PREVIOUS, TAG8_4S16), 4),
        Field("vbatLatest", False, (VBAT, NEG_14BIT), (PREVIOUS, TAG8_8SVB)),
        Field("amperageLatest", True, (ZERO, SVB), (PREVIOUS, TAG8_8SVB)),
        *vector("magADC", (ZERO, SVB), (PREVIOUS, TAG8_8SVB)),
        Field("baroAlt", True, (ZERO, SVB), (PREVIOUS, TAG8_8SVB)),
        *vector("gyroADC", *average),
        *vector("accSmooth", *average),
        *vector("imuQuaternion", *average),
        Field("motor[0]", False, (MIN_MOTOR, UVB), (AVERAGE, SVB)),
        *(Field(f"motor[{k}]", False, (MOTOR_0, SVB), (AVERAGE, SVB)) for k in range(1, 4)),
    ]


def inav_fields() -> list[Field]:
    """The main fields of INAV 7 that tests need, in its order; axisI in a group of varied length."""
    average = ((ZERO, SVB), (AVERAGE, SVB))
    return [
        Field("loopIteration", False, (ZERO, UVB), (INCREMENT, NOTHING)),
        Field("time", False, (ZERO, UVB), (LINE, SVB)),
        *vector("axisI", (ZERO, SVB), (PREVIOUS, TAG2_3SVARIABLE)),
        Field("vbat", False, (VBAT, NEG_14BIT), (PREVIOUS, TAG8_8SVB)),
        Field("amperage", True, (ZERO, SVB), (PREVIOUS, TAG8_8SVB)),
        *vector("magADC", (ZERO, SVB), (PREVIOUS, TAG8_8SVB)),
        *vector("gyroADC", *average),
        *vector("accSmooth", *average),
        *vector("attitude", *average),
        Field("motor[0]", False, (MIN_THROTTLE, UVB), (AVERAGE, SVB)),
        *vector("navPos", (ZERO, SVB), (PREVIOUS, SVB)),
    ]


SLOW = [
    *(Field(name, False, (ZERO, UVB)) for name in ("flightModeFlags", "activeFlightModeFlags", "stateFlags")),
    *(Field(name, False, (ZERO, TAG2_3S32)) for name in ("failsafePhase", "rxSignalReceived", "rxFlightChannelsValid")),
    Field("IMUTemperature", True, (ZERO, SVB)),
]
GPS = [
    Field("time", False, (MAIN_TIME, UVB)),
    Field("GPS_numSat", False, (ZERO, UVB)),
    *(Field(f"GPS_coord[{k}]", True, (HOME, SVB)) for k in range(2)),
    Field("GPS_altitude", True, (ZERO, SVB)),
]
HOME_FIELDS = [Field(f"GPS_home[{k}]", True, (ZERO, SVB)) for k in range(2)]


def unsigned(value: int) -> bytes:
    """Seven bits a byte, the lowest first."""
    value &= 0xFFFFFFFF
    found = bytearray()
    while value > 127:
        found.append(value & 127 | 128)
        value >>= 7
    return bytes((*found, value))


def signed(value: int) -> bytes:
    """Zigzag of 32 bits: 0, -1, 1, -2, ... as 0, 1, 2, 3."""
    value = (value + 2**31) % 2**32 - 2**31
    return unsigned(2 * value if value >= 0 else -2 * value - 1)


PACKINGS = {
    False: (((2, 2, 2), (2, 2, 2)), ((4, 4, 4), (6, 4, 4)), ((6, 6, 6), (6, 8, 8))),
    True: (((2, 2, 2), (2, 2, 2)), ((5, 5, 4), (5, 5, 4)), ((8, 7, 7), (8, 7, 7))),
}
"""Bits of three values that a packing holds, and the bits between their ends; whether varied."""


def three(values: Sequence[int], varied: bool) -> bytes:
    """Two bits for the packing, then three values in the first that holds them, or whole bytes for each."""
    for kind, (limits, widths) in enumerate(PACKINGS[varied]):
        if all(-(1 << n - 1) <= one < 1 << n - 1 for one, n in zip(values, limits, strict=True)):
            bits = kind
            for one, n, width in zip(values, limits, widths, strict=True):
                bits = bits << width | one & (1 << n) - 1
            return bits.to_bytes(kind + 1, "big")
    return _whole_bytes(values)


def _whole_bytes(values: Sequence[int]) -> bytes:
    sizes = [next(size for size in range(1, 5) if -(1 << 8 * size - 1) <= one < 1 << 8 * size - 1) for one in values]
    lead = 192 | sum((size - 1) << 2 * k for k, size in enumerate(sizes))
    whole = (one.to_bytes(size, "little", signed=True) for one, size in zip(values, sizes, strict=True))
    return bytes([lead]) + b"".join(whole)


def four(values: Sequence[int]) -> bytes:
    """Half bytes, the high half first: none, one, two or four for each value."""
    kinds = [0 if one == 0 else 1 if -8 <= one < 8 else 2 if -128 <= one < 128 else 3 for one in values]
    digits = ""
    for value, kind in zip(values, kinds, strict=True):
        halves = (0, 1, 2, 4)[kind]
        digits += f"{value & 16**halves - 1:0{halves}x}" if halves else ""
    digits += "0" * (len(digits) % 2)
    return bytes([sum(kind << 2 * k for k, kind in enumerate(kinds))]) + bytes.fromhex(digits)


def eight(values: Sequence[int]) -> bytes:
    """A byte of which values are there, then these; a single value without the byte."""
    if len(values) == 1:
        return signed(values[0])
    lead = sum((one != 0) << k for k, one in enumerate(values))
    return bytes([lead]) + b"".join(signed(one) for one in values if one)


def encoded(values: Sequence[int], encodings: Sequence[int]) -> bytes:
    """Differences as bytes, in groups."""
    found, i = b"", 0
    while i < len(values):
        encoding, size = encodings[i], 1
        if encoding in (TAG2_3S32, TAG2_3SVARIABLE):
            size = 3
            found += three(values[i : i + 3], encoding == TAG2_3SVARIABLE)
        elif encoding == TAG8_4S16:
            size = 4
            found += four(values[i : i + 4])
        elif encoding == TAG8_8SVB:
            while size < 8 and encodings[i + size : i + size + 1] == [TAG8_8SVB]:
                size += 1
            found += eight(values[i : i + size])
        elif encoding != NOTHING:
            found += unsigned(-values[i] & 0x3FFF) if encoding == NEG_14BIT else _single(values[i], encoding)
        i += size
    return found


def _single(value: int, encoding: int) -> bytes:
    return signed(value) if encoding == SVB else unsigned(value)


@dataclass
class BlackboxWriter:
    """A log under construction: header, then frames with differences from the last two."""

    fields: Sequence[Field]
    headers: Mapping[str, str]
    interval: int = 32
    data: bytearray = field(default_factory=bytearray)
    written: int = 0
    history: list[list[int]] = field(default_factory=list)
    home: tuple[int, int] = (0, 0)

    def __post_init__(self) -> None:
        """Write the header."""
        lines = [START, "H Data version:2", f"H I interval:{self.interval}", "H P interval:1/1"]
        for letter, some in (("I", self.fields), ("S", SLOW), ("G", GPS), ("H", HOME_FIELDS)):
            lines += [f"H Field {letter} {what}:{values}" for what, values in _definition(some).items()]
        lines.append(f"H Field P predictor:{_joined(one.further[0] for one in self.fields)}")
        lines.append(f"H Field P encoding:{_joined(one.further[1] for one in self.fields)}")
        lines += [f"H {name}:{value}" for name, value in self.headers.items()]
        self.data += "\n".join([*lines, ""]).encode()
        self.names = [one.name for one in self.fields]

    def main(self, row: Mapping[str, int]) -> None:
        """Write a main frame: I at each interval, else P."""
        values = [int(row.get(name, 0)) for name in self.names]
        if self.written % self.interval == 0:
            kinds = [one.first for one in self.fields]
            last = before = [0] * len(values)
        else:
            kinds = [one.further for one in self.fields]
            last, before = self.history
        found = [
            0 if kind == NOTHING else value - self._prediction(predictor, k, values, last, before)
            for k, (value, (predictor, kind)) in enumerate(zip(values, kinds, strict=True))
        ]
        self.data += b"I" if self.written % self.interval == 0 else b"P"
        self.data += encoded(found, [kind for _, kind in kinds])
        self.history = [values, values if self.written % self.interval == 0 else last]
        self.written += 1

    def _prediction(self, kind: int, k: int, now: list[int], last: list[int], before: list[int]) -> int:
        """Return what a value is predicted to be."""
        low = int(self.headers.get("motorOutput", "0").split(",")[0])
        references = {
            FIXED: 1500,
            MIN_MOTOR: low,
            MIN_THROTTLE: int(self.headers.get("minthrottle", 0)),
            VBAT: int(self.headers.get("vbatref", 0)),
            PREVIOUS: last[k],
            LINE: 2 * last[k] - before[k],
            AVERAGE: int((last[k] + before[k]) / 2),
            MOTOR_0: now[self.names.index("motor[0]")] if "motor[0]" in self.names else 0,
        }
        return references.get(kind, 0)

    def slow(self, **values: int) -> None:
        """Write a slow frame."""
        self.data += b"S" + encoded([values.get(one.name, 0) for one in SLOW], [one.first[1] for one in SLOW])

    def fix(self, latitude: int, longitude: int, altitude: int) -> None:
        """Write a home frame at the first fix, then the fix."""
        if self.home == (0, 0):
            self.home = (latitude, longitude)
            self.data += b"H" + signed(latitude) + signed(longitude)
        apart = latitude - self.home[0], longitude - self.home[1]
        self.data += b"G" + unsigned(0) + unsigned(9) + signed(apart[0]) + signed(apart[1]) + signed(altitude)

    def end(self) -> bytes:
        """Write the end mark; return the log."""
        return bytes(self.data + b"E\xffEnd of log\x00")


def _definition(fields: Sequence[Field]) -> dict[str, str]:
    """Return the lines that define a frame."""
    columns = {
        "name": [one.name for one in fields],
        "signed": [int(one.signed) for one in fields],
        "predictor": [one.first[0] for one in fields],
        "encoding": [one.first[1] for one in fields],
    }
    return {what: _joined(values) for what, values in columns.items()}


def _joined(values: Iterable[object]) -> str:
    return ",".join(str(one) for one in values)


def rows_of(columns: Mapping[str, Array]) -> list[dict[str, int]]:
    """Return columns of equal length as rows of whole numbers; a vector (n, 3) under "name" becomes name[0] ..."""
    flat: dict[str, list[int]] = {}
    for name, values in columns.items():
        parts = {name: values} if values.ndim == 1 else {f"{name}[{k}]": one for k, one in enumerate(values.T)}
        flat |= {one: np.round(part).astype(int).tolist() for one, part in parts.items()}
    return [dict(zip(flat, row, strict=True)) for row in zip(*flat.values(), strict=True)]
