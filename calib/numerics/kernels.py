"""Compiled loops with sums in any order; `sim.effects.kernels` keeps the order, for equal bytes on every machine."""

from __future__ import annotations

from collections.abc import Callable
from typing import ParamSpec, TypeVar

from scenarios.kernel_cache import njit

P = ParamSpec("P")
T = TypeVar("T")


def fast_kernel(function: Callable[P, T]) -> Callable[P, T]:
    """Compile a loop: cached on disk, free of the interpreter's lock, sums in any order; inputs must be finite."""
    compiled: Callable[P, T] = njit(cache=True, nogil=True, fastmath=True, error_model="numpy")(function)
    return compiled
