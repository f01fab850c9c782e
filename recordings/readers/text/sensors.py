"""The words by which lines of a log name their sensor, and the columns that such lines hold."""

from __future__ import annotations

import re
from collections.abc import Sequence

KINDS = {
    "mag": r"mag|compass|^m$|^b$|hmc5|qmc5|lis[23]m|ak8|ak09|bmm|rm3100|mmc5|mlx9|ist83",
    "accel": r"acc|^a$",
    "gyro": r"gyr|^g$|^w$",
}
"""Sensors by what occurs in the letters of a word."""
BEST = r"raw|uncal"
"""What a word of values without the instrument's own calibration contains."""
NINE = ("raw", "uni")
"""MotionCal's lines: accelerometer, gyro and magnetometer, each x, y, z; in counts, and in units."""
COUNTS = {"accel": (1 / 8192, "g"), "gyro": (1 / 16, "deg/s"), "mag": (0.1, "uT")}
"""MotionCal's counts: value of a count, and its unit."""
AXES = ("x", "y", "z")
_MAG, _ACCEL, _RATE = ([f"{name}{axis}" for axis in "XYZ"] for name in ("Mag", "Accel", "AngularRate"))
_RAW = [f"Uncomp{name}" for name in _MAG]
SENTENCES = {
    "vnymr": ("Yaw", "Pitch", "Roll", *_MAG, *_ACCEL, *_RATE),
    "vnmar": (*_MAG, *_ACCEL, *_RATE),
    "vnimu": (*_RAW, *_ACCEL, *_RATE, "Temperature", "Pressure"),
}
"""VectorNav's lines of text with a magnetometer, and their values as its tables call them."""


def letters(word: str) -> str:
    """Return a word's letters and digits, in lower case."""
    return re.sub(r"[^a-z0-9]", "", word.lower())


def kind_of(word: str) -> str | None:
    """Return the sensor that a word names."""
    bare = letters(word)
    return next((kind for kind, pattern in KINDS.items() if re.search(pattern, bare)), None)


def is_nine(word: str, values: int) -> bool:
    """Return whether lines of this word and number of values are MotionCal's."""
    return letters(word) in NINE and values == len(NINE_NAMES)


def is_sentence(word: str, values: int) -> bool:
    """Return whether lines of this word and number of values are VectorNav's."""
    return len(SENTENCES.get(letters(word), ())) == values


NINE_NAMES = tuple(f"{kind}_{axis}" for kind in ("accel", "gyro", "mag") for axis in AXES)


def magnetometer_among(words: dict[str, int]) -> str | None:
    """Return the word of the magnetometer's lines, uncalibrated values first; `words` gives the values of each."""
    found = [
        word
        for word, values in words.items()
        if kind_of(word) == "mag" or is_nine(word, values) or is_sentence(word, values)
    ]
    return min(found, key=lambda word: not re.search(BEST, letters(word)), default=None)


def prefix(word: str) -> str:
    """Return the first part of the names of a sensor's columns."""
    return kind_of(word) or letters(word) or "value"


def names_of(word: str, given: Sequence[str], values: int, timed: bool, run: int) -> list[str]:
    """Return the names of the values in lines of a word: as given, else `mag_x` and so on after a time.

    given : names from a header, empty where there is none; a single letter gets the sensor's name before it.
    timed : whether the first value is a time.
    run : the numbers that follow the time without words between them.
    """
    if is_nine(word, values):
        return [f"{letters(word)}_{name}" for name in NINE_NAMES]
    if is_sentence(word, values):
        return list(SENTENCES[letters(word)])
    sensor = prefix(word)
    if given:
        return [f"{sensor}_{name.lower()}" if name.lower() in AXES else name for name in given]
    behind = [str(k + 1) for k in range(values - timed)]
    parts = [*AXES, *behind[len(AXES) :]] if run == len(AXES) <= len(behind) else behind
    return [*["time"][: int(timed)], *(f"{sensor}_{part}" for part in parts)]
