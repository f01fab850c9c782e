"""Conversion of results to plain values for JSON."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from typing import Any


def _same(value: Any) -> Any:
    return value


def plain(value: Any, leaf: Callable[[Any], Any] = _same) -> Any:
    """Return Python's own types: lists for arrays (`tolist`) and tuples, text for keys, `leaf(value)` for all else."""
    if isinstance(value, Mapping):
        return {str(key): plain(part, leaf) for key, part in value.items()}
    if isinstance(value, list | tuple):
        return [plain(part, leaf) for part in value]
    return plain(value.tolist(), leaf) if hasattr(value, "tolist") else leaf(value)


def json_ready(value: Any) -> Any:
    """Return plain values for JSON, with None for numbers that are not finite."""
    return plain(value, _finite)


def _finite(value: Any) -> Any:
    return None if isinstance(value, float) and not math.isfinite(value) else value
