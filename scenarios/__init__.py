"""What to simulate: frozen scenario specs, reference paths, the catalogue; errors and files of every package."""

from scenarios.numba_cache import ensure_numba_cache

ensure_numba_cache()
