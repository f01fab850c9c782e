"""Column names of foreign logs taken apart: words, component of a vector, unit."""

from __future__ import annotations

import re
from dataclasses import dataclass
from functools import cached_property

from recordings.reading import COUNT

KINDS: dict[str, str] = {
    "mag": "mag magn magnet magnetic magnetometer magneto magfield compass uncalmag magadc field b m h bfield",
    "gyro": "gyro gyr gyroscope rotation rotationrate omega w g angular rate",
    "accel": "acc accel acceleration accelerometer accelero a",
}
"""Words of a name by quantity; a bare x, y, z is the magnetometer's where nothing else is."""
WORDS = {word: kind for kind, words in KINDS.items() for word in words.split()}
FILLERS = {
    *("field", "sensor", "imu", "velocity", "vector", "data", "value"),
    *("values", "axis", "in", "the", "device", "body"),
}
RAW = {"raw", "uncal", "uncalibrated", "uncalmag", "adc", "unfiltered"}
DERIVED = {"motion", "cal", "calibrated", "corrected", "comp", "compensated", "filt", "filtered", "lpf", "smooth"}
NO_MEASUREMENT = {
    "bias",
    "offset",
    "ofs",
    "hard",
    "soft",
    "var",
    "std",
    "cov",
    "covariance",
    "error",
    "err",
    "linear",
    "user",
    "gravity",
    "scale",
    "gain",
    "sensitivity",
    "min",
    "max",
    "delta",
    "diff",
    "heading",
    "azimuth",
    "norm",
    "total",
    "magnitude",
    "accuracy",
    "true",
    "effect",
    "reference",
}
"""Words of columns that are no measured vector: an offset, a spread, a scale, acceleration without gravity."""
TIMES = [
    "time_s",
    "t",
    "time",
    "timestamp",
    "seconds_elapsed",
    "elapsed_realtime",
    "elapsed",
    "ts",
    "seconds",
    "secs",
    "sec",
    "s",
    "millis",
    "ms",
    "micros",
    "us",
    "datetime",
    "date_time",
    "datenum",
    "utc",
    "epoch",
    "clock",
    "timeus",
    "time_boot",
    "zeit",
    "date",
]
"""Words of columns of time, the better ones first."""
SPELT: dict[str, dict[str, str]] = {
    "time": {
        **dict.fromkeys(("s", "sec", "secs", "second", "seconds"), "s"),
        **dict.fromkeys(("ms", "msec", "millis", "millisecond", "milliseconds", "millisec"), "ms"),
        **dict.fromkeys(("us", "usec", "micros", "microsecond", "microseconds", "µs", "μs"), "us"),
        **dict.fromkeys(("ns", "nsec", "nanos", "nanosecond", "nanoseconds"), "ns"),
        **dict.fromkeys(("min", "minutes"), "min"),
    },
    "mag": {
        **dict.fromkeys(("nt", "nanotesla", "nanoteslas", "gamma"), "nT"),
        **dict.fromkeys(("ut", "µt", "μt", "microt", "microtesla", "microteslas"), "uT"),
        **dict.fromkeys(("mt", "millitesla"), "mT"),
        **dict.fromkeys(("tesla", "teslas"), "T"),
        **dict.fromkeys(("gauss", "gs", "ga"), "G"),
        **dict.fromkeys(("mg", "mgauss", "milligauss", "mga"), "mG"),
        **dict.fromkeys(("count", "counts", "lsb", "adc", "digit", "digits", "ticks"), COUNT),
    },
    "gyro": {
        **dict.fromkeys(("rad/s", "rads", "radps", "rps", "rad/sec", "radpersec", "radians/s"), "rad/s"),
        **dict.fromkeys(("deg/s", "degs", "dps", "degps", "°/s", "deg/sec", "degpersec", "degrees/s"), "deg/s"),
    },
    "accel": {
        **dict.fromkeys(("m/s^2", "m/s2", "m/s²", "ms2", "mps2", "m/s/s", "mss"), "m/s^2"),
        **dict.fromkeys(("g", "gs", "gee"), "g"),
        "mg": "mg",
    },
    "temperature": {**dict.fromkeys(("c", "degc", "°c", "celsius"), "degC"), "k": "K", "f": "degF", "°f": "degF"},
}
"""Units by quantity, as people write them, in lower case."""

ALONE = {"t": "T", "g": "G"}
"""Units of a field that are read in brackets alone: as words they are the time and the gyro."""


@dataclass(frozen=True)
class ColumnName:
    """The name of a column, taken apart."""

    name: str

    @cached_property
    def words(self) -> tuple[str, ...]:
        """The words in lower case, apart at signs and capitals, without brackets: `MagX [mG]` is mag, x."""
        bare = re.sub(r"\(.*?\)|\[.*?\]", " ", self.name)
        return tuple(w.lower() for w in re.findall(r"[A-Z]+(?![a-zµμ])|[A-Z]?[a-zµμ°]+|\d+", bare))

    @cached_property
    def bracketed(self) -> str:
        """The text in brackets, without a leading "in"."""
        found = re.findall(r"[(\[]\s*(?:in\s+)?([^)\]]*?)\s*[)\]]", self.name)
        return next((text.lower() for text in found if not text.isdigit()), "")

    def unit(self, kind: str) -> str | None:
        """Return the unit in the name, in brackets or as the last words."""
        spelt = SPELT.get(kind, {})
        if kind == "mag" and self.bracketed in ALONE:
            return ALONE[self.bracketed]
        tails = ("".join(self.words[-k:]) for k in (3, 2, 1) if len(self.words) > k or kind == "time")
        return next((spelt[text] for text in (self.bracketed, *tails) if text in spelt), None)

    @property
    def indexed(self) -> str:
        """The component x, y or z of a name that ends in [0], [1] or [2], and a unit or none; "" for another name."""
        found = re.search(r"\[([012])\]\s*(?:\([^)]*\))?\s*$", self.name)
        return "xyz"[int(found[1])] if found else ""

    def component(self, of: str) -> tuple[str, frozenset[str]] | None:
        """Return the component of a vector's column and the other words; None for another column.

        of : the components, "xyz" or "wxyz". A component is a word, the first or last letter of the only word, or of x,
        y and z a number in brackets: `magADC[0]` of a blackbox log is x.
        """
        words = self.plain
        if self.indexed in tuple(of):
            return self.indexed, frozenset(words)
        letters = [k for k, word in enumerate(words) if word in of and len(word) == 1]
        if letters:
            at = letters[-1]
            return words[at], frozenset(words[:at] + words[at + 1 :])
        for k, word in enumerate(words):
            for letter, rest in ((word[-1], word[:-1]), (word[0], word[1:])):
                if letter in of and (rest in WORDS or rest in ("q", "quat")):
                    return letter, frozenset((*words[:k], rest, *words[k + 1 :]))
        return None

    @property
    def plain(self) -> tuple[str, ...]:
        """The words without those of a unit at the end."""
        units = {text for spelt in SPELT.values() for text in spelt}
        for k in (3, 2, 1):
            if len(self.words) > k and "".join(self.words[-k:]) in units:
                return self.words[:-k]
        return self.words
