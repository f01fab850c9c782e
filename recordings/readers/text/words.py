"""The kinds of a cell in a text log: a number, an empty mark, a time, a unit, a comment."""

from __future__ import annotations

import re

NULLS = (
    "",
    "nan",
    "-nan",
    "+nan",
    "na",
    "n/a",
    "#n/a",
    "null",
    "none",
    "nil",
    "-",
    "--",
    "---",
    "1.#ind",
    "-1.#ind",
    "1.#qnan",
)
INFINITE = ("inf", "+inf", "-inf", "infinity", "-infinity", "1.#inf", "-1.#inf")
EMPTY = frozenset((*NULLS, *INFINITE))
"""Cells without a value, in lower case."""
_CASES = (str, str.upper, str.capitalize, lambda word: word.replace("nan", "NaN").replace("inf", "Inf"))
SPELT = sorted({case(word) for word in EMPTY if not word.startswith("-") for case in _CASES})
"""The cells that Arrow's CSV reader is to look for: without a minus, by which every negative number would be slower."""

NUMBER = r"[+-]?(?:\d+\.?\d*|\.\d+)(?:[eE][+-]?\d+)?"
"""A decimal number with a point."""
GROUPED = r"[+-]?\d{1,3}(?:,\d{3})+\.\d+"
"""A number with marks between thousands: with a decimal mark too, else 1,234 might be either."""
CLOCK = r"\d{1,2}:\d{2}(?::\d{2}(?:[.,:]\d{1,9})?)?(?:\s*[AaPp]\.?[Mm]\.?)?"
DATE = (
    r"(?:\d{4}[-/.]\d{1,2}[-/.]\d{1,2}|\d{1,2}[-/.]\d{1,2}[-/.](?:\d{4}|\d{2})|\d{1,2}[- ][A-Za-z]{3}[a-z]*[- ]\d{4})"
)
ZONE = r"(?:\s*(?:Z|UTC|GMT|[+-]\d{2}(?::?\d{2})?))?"
COMPACT = r"\d{8}T\d{6}(?:\.\d{1,9})?"
TIME = rf"(?:{COMPACT}{ZONE}|{DATE}(?:[T ,_]\s*{CLOCK}{ZONE})?|{CLOCK}{ZONE})"

COMMENT_MARKS = ("#", "%", "//", ";")
_TIME = re.compile(TIME)
_UNITS = """
s sec secs second seconds ms msec us usec µs μs ns min h hh:mm:ss utc iso ts rn
nt ut µt μt mt t pt g gs gauss mg mgauss ga count counts cnt lsb adc raw tesla microtesla nanotesla
rad/s rad_s deg/s deg_s °/s dps mrad/s m/s m/s2 m/s^2 m/s² m/s**2 m_s2
degc °c c k degf °f deg ° rad degrees hpa pa kpa mbar v mv a ma w % m cm mm km ft knots kn 1 - smp avg
"""
"""Words of a row of units; the last four are what data loggers write for counts, nothing, samples and means."""
_UNIT_WORDS = frozenset(_UNITS.split())


def with_comma(pattern: str) -> str:
    """Return a pattern of numbers with points for decimal commas, and with commas for points."""
    return pattern.replace(r"\.", "\0").replace(",", r"\.").replace("\0", ",").replace(r"{1\.3}", "{1,3}")


_NUMBERS = {
    ".": re.compile(f"{NUMBER}|{GROUPED}"),
    ",": re.compile(with_comma(f"{NUMBER}|{GROUPED}")),
}
"""Numbers by the decimal mark."""


def is_empty_mark(cell: str) -> bool:
    """Return whether the cell stands for no value."""
    return cell.strip().lower() in EMPTY


def is_value(cell: str, decimal: str) -> bool:
    """Return whether the cell is a number, with this decimal mark and a unit or none, or a time."""
    text = cell.strip()
    if _NUMBERS[decimal].fullmatch(text) or _TIME.fullmatch(text):
        return True
    number, _, unit = text.partition(" ")
    return bool(unit and is_unit(unit) and _NUMBERS[decimal].fullmatch(number))


def plain_number(cell: str, decimal: str) -> float | None:
    """Return a number without marks of thousands; None for another cell."""
    text = cell.strip().replace(decimal, ".")
    return float(text) if re.fullmatch(NUMBER, text) else None


def is_unit(cell: str) -> bool:
    """Return whether the cell is a unit: in brackets, or a known word."""
    text = cell.strip()
    return text[:1] + text[-1:] in ("[]", "()") or text.lower() in _UNIT_WORDS


def is_comment(line: str, delimiter: str) -> bool:
    """Return whether the line is blank or a comment; a semicolon marks one where no semicolon stands between cells."""
    text = line.strip()
    return not text or (text.startswith(COMMENT_MARKS) and not (text[0] == ";" and delimiter == ";"))


def without_mark(line: str) -> str:
    """Return a comment's text."""
    return line.strip().lstrip("#%/;").strip()
