"""Scenarios, what to simulate: frozen tables, reference paths, the catalogue; and the errors of every package."""

from scenarios.numba_cache import ensure_numba_cache

ensure_numba_cache()
