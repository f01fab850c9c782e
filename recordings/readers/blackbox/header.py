"""The header of a blackbox log: what the flight controller says of itself, and how its frames are encoded."""

from __future__ import annotations

import datetime
import re
import struct
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

from recordings.readers.blackbox import kernel
from scenarios.errors import InputError

START = b"H Product:Blackbox flight data recorder"
"""The first line of every log; a file may hold several logs."""
MAGNETOMETER = tuple(f"magADC[{k}]" for k in range(3))
"""The fields of the magnetometer."""
LONGEST_LINE = 1 << 14
MOST_FIELDS = 180
"""Fields of a frame; Betaflight has about 80, INAV 140."""
DATA_VERSION = 2
"""The version of the encoding since 2014; the group of four was another before."""
DEFAULTS = {"minthrottle": 1150.0, "vbatref": 4095.0}
"""Values of headers that a log may lack, as its decoders take them."""


@dataclass(frozen=True)
class FrameFields:
    """The fields of a kind of frame, by place: names, numbers of encoding and predictor, signs."""

    names: tuple[str, ...]
    encodings: tuple[int, ...]
    predictors: tuple[int, ...]
    signed: tuple[int, ...]


@dataclass(frozen=True, eq=False)
class Header:
    """The header of a log.

    values : name -> text, as "acc_1G" -> "2048". frames : by the letter of a frame, its fields.
    """

    values: Mapping[str, str]
    frames: Mapping[str, FrameFields] = field(default_factory=dict)

    def numbers(self, name: str) -> tuple[float, ...]:
        """Return the numbers of a header, () where there is none."""
        texts = self.values.get(name, "").split(",")
        try:
            return tuple(float(text) for text in texts)
        except ValueError:
            return ()

    def number(self, name: str, default: float) -> float:
        """Return the first number of a header that is finite and not zero."""
        found = next(iter(self.numbers(name)), 0.0)
        return found if np.isfinite(found) and found else default

    @property
    def firmware(self) -> str:
        """The firmware's name: "Betaflight", "INAV", "Cleanflight", ..."""
        return (self.values.get("Firmware revision") or self.values.get("Firmware type", "")).split(" ")[0]

    @property
    def version(self) -> int:
        """The first number of the firmware's version, 0 where it is not told; Betaflight's years count as later."""
        found = re.search(r"\b(\d{1,4})\.\d+", self.values.get("Firmware revision", ""))
        return int(found[1]) if found else 0

    @property
    def gyro_scale(self) -> float:
        """The rad/s of a count: `gyro_scale` is a float's bits in deg/s, of Baseflight in rad/us."""
        text = self.values.get("gyro_scale", self.values.get("gyro.scale", ""))
        try:
            scale = float(struct.unpack(">f", struct.pack(">I", int(text, 16)))[0])
        except (ValueError, struct.error):
            scale = 1.0
        if not np.isfinite(scale) or scale <= 0:
            scale = 1.0
        return scale * 1e6 if scale < 1e-6 else float(np.deg2rad(scale))

    @property
    def date(self) -> datetime.date | None:
        """The date of the log's start; None where the clock was not set."""
        try:
            found = datetime.date.fromisoformat(self.values.get("Log start datetime", "")[:10])
        except ValueError:
            return None
        return found if found.year >= 2000 else None

    def constants(self) -> kernel.Integers:
        """Return the numbers on which predictions build, see `kernel`."""
        found = np.zeros(kernel.CONSTANTS, np.int64)
        low = self.number("minthrottle", DEFAULTS["minthrottle"])
        outputs = self.numbers("motorOutput")
        names = self.frames["I"].names
        bounded = [low, self.number("vbatref", DEFAULTS["vbatref"]), outputs[0] if outputs else low]
        found[[kernel.MIN_THROTTLE, kernel.VBAT_REFERENCE, kernel.MIN_MOTOR]] = np.clip(bounded, -1e9, 1e9)
        found[kernel.MOTOR_0] = names.index("motor[0]") if "motor[0]" in names else 0
        return found


def read_header(path: Path, data: bytes) -> tuple[Header, int]:
    """Return the header of a log that begins at the first byte, and the place of the first frame.

    Raises InputError for fields of unknown encodings, and for a log without a magnetometer.
    """
    lines = list(_lines(data))
    values = {key: value for key, value, _ in lines}
    header = Header(values, _frames(values))
    what = _wrong(header)
    if what:
        raise InputError(what, where=str(path), do="give another log, or its CSV by blackbox_decode")
    return header, lines[-1][2]


def _lines(data: bytes) -> Iterator[tuple[str, str, int]]:
    """Yield name, value and the place behind each line of the header; a place without a line ends it."""
    at = 0
    while data[at : at + 2] == b"H ":
        end = data.find(b"\n", at, at + LONGEST_LINE)
        line = data[at + 2 : end]
        if end < 0 or b":" not in line:
            return
        name, _, value = line.decode("latin-1").partition(":")
        at = end + 1
        yield name.strip(), value.strip(), at


def _frames(values: Mapping[str, str]) -> dict[str, FrameFields]:
    """Return the fields of each kind of frame whose lines agree; the P frame has the names of the I frame."""
    found = {}
    for letter in "IPSGH":
        names = values.get(f"Field {'I' if letter == 'P' else letter} name", "")
        rows = [_integers(values.get(f"Field {letter} {what}", "")) for what in ("encoding", "predictor")]
        signed = _integers(values.get(f"Field {'I' if letter == 'P' else letter} signed", ""))
        listed = tuple(name.strip() for name in names.split(",")) if names else ()
        if listed and all(len(row) == len(listed) for row in (*rows, signed)):
            found[letter] = FrameFields(listed, rows[0], _second_home(rows[1]), signed)
    return found


def _integers(text: str) -> tuple[int, ...]:
    try:
        return tuple(int(one) for one in text.split(","))
    except ValueError:
        return ()


def _second_home(predictors: tuple[int, ...]) -> tuple[int, ...]:
    """Return predictors with 256 for the second of two home coordinates in a row."""
    return tuple(256 if k and one == predictors[k - 1] == 7 else one for k, one in enumerate(predictors))


def _wrong(header: Header) -> str:
    """Return what is wrong with a header, "" for nothing."""
    if not {"I", "P"} <= header.frames.keys():
        return "is a blackbox log whose header does not define its frames"
    if header.number("Data version", DATA_VERSION) != DATA_VERSION:
        return f"is a blackbox log of data version {header.values['Data version'][:9]}, of 2014 or before"
    if max(len(one.names) for one in header.frames.values()) > MOST_FIELDS:
        return f"is a blackbox log of more than {MOST_FIELDS} fields"
    unknown = sorted(_unknown(header))
    if unknown:
        return f"is a blackbox log with an unknown encoding or predictor {unknown[0]}"
    if not {"time", *MAGNETOMETER} <= set(header.frames["I"].names):
        return "is a blackbox log without magADC: the magnetometer was not logged"
    return ""


def _unknown(header: Header) -> set[int]:
    """Return the numbers of encodings and of predictors that are not decoded."""
    frames = header.frames.values()
    encodings = {one for frame in frames for one in frame.encodings} - set(kernel.ENCODINGS)
    return encodings | {one for frame in frames for one in frame.predictors} - set(kernel.PREDICTORS)
