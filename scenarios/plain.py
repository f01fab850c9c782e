"""Results as plain values, for JSON."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from typing import Any


def _same(value: Any) -> Any:
    return value


def plain(value: Any, leaf: Callable[[Any], Any] = _same) -> Any:
    """A value as Python's own: arrays (all that has `tolist`) and tuples as lists, keys as text; `leaf` of the rest."""
    if isinstance(value, Mapping):
        return {str(key): plain(part, leaf) for key, part in value.items()}
    if isinstance(value, list | tuple):
        return [plain(part, leaf) for part in value]
    return plain(value.tolist(), leaf) if hasattr(value, "tolist") else leaf(value)


def json_ready(value: Any) -> Any:
    """A result as JSON holds it: plain, and None for what is not finite."""
    return plain(value, _finite)


def _finite(value: Any) -> Any:
    return None if isinstance(value, float) and not math.isfinite(value) else value
