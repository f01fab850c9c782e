"""Random streams by name: independent, random-access, and unmoved when others are added or removed."""

from __future__ import annotations

from zlib import crc32

import numpy as np


def stream(seed: int, run: int, *names: str | int) -> np.random.Generator:
    """Generator for one named source of randomness of one run; the same arguments give the same stream."""
    keys = tuple(crc32(name.encode()) if isinstance(name, str) else name for name in names)
    return np.random.Generator(np.random.SFC64(np.random.SeedSequence(seed, spawn_key=(run, *keys))))
