"""Values that were not meant, and the places where they are put into JSON, TOML and tables."""

from __future__ import annotations

import copy
import json
from typing import Any

from hypothesis import strategies as st

NUMBERS = (0, -1, 3, 10**9, 10**400, 0.0, -0.0, 1e-320, 5e-324, 1e-9, 1e30, 1e300, 1.7976931348623157e308, float("nan"))
ODD_TEXTS = (
    "",
    " ",
    "x" * 3000,
    "tab\there",
    "two\nlines",
    "\x00\x1b[31m",
    "naïve 磁",
    "\ud800",
    "nan",
    "1e5",
    "../../x",
)
ENDINGS = ("", "}", "]", ",", '"', "NaN", "1e999", "[" * 3000, "9" * 5000)


def _nested(depth: int) -> Any:
    value: Any = 1.0
    for _ in range(depth):
        value = [value]
    return value


numbers = st.sampled_from((*NUMBERS, *(-n for n in NUMBERS), float("inf")))
texts = st.sampled_from(ODD_TEXTS)
anything = st.one_of(
    numbers,
    texts,
    st.none(),
    st.booleans(),
    st.sampled_from([[], {}, [[]], [1, 2], [1, 2, 3, 4], {"a": 1}, [None, 1, 2], ["1", "2", "3"], [[1, 2, 3]] * 3]),
    st.integers(1, 300).map(_nested),
)


@st.composite
def damaged_json(draw: st.DrawFn, base: Any) -> str:
    """A JSON text with one to three values changed, keys dropped, added or renamed; now and then cut off."""
    value = copy.deepcopy(base)
    for _ in range(draw(st.integers(1, 3))):
        value = _changed(draw, value)
    text = json.dumps(value)
    if draw(st.integers(0, 9)) == 0:
        at = draw(st.integers(0, len(text)))
        text = (
            text[:at]
            + draw(st.sampled_from(["", "}", "]", ",", '"', "NaN", "1e999", "[" * 3000, "9" * 5000]))
            + text[at + 1 :]
        )
    return text


def _changed(draw: st.DrawFn, value: Any) -> Any:
    """The value with one place in it changed, found by walking down at random."""
    if isinstance(value, dict) and value and draw(st.integers(0, 9)) > 0:
        return _changed_table(draw, value)
    if isinstance(value, list) and value and draw(st.integers(0, 9)) > 0:
        return _changed_list(draw, value)
    return draw(anything)


def _changed_table(draw: st.DrawFn, value: dict[str, Any]) -> dict[str, Any]:
    key = draw(st.sampled_from(sorted(value)))
    how = draw(st.integers(0, 9))
    if how == 0:
        return {k: v for k, v in value.items() if k != key}
    if how == 1:
        return {**value, draw(texts): draw(anything)}
    if how == 2:
        return {(draw(texts) if k == key else k): v for k, v in value.items()}
    return {**value, key: _changed(draw, value[key])}


def _changed_list(draw: st.DrawFn, value: list[Any]) -> list[Any]:
    at = draw(st.integers(0, len(value) - 1))
    how = draw(st.integers(0, 9))
    if how == 0:
        return value[:at] + value[at + 1 :]
    if how == 1:
        return [*value, draw(anything)]
    return [*value[:at], _changed(draw, value[at]), *value[at + 1 :]]
