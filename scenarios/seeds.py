"""Random streams by name: independent, random-access, and unmoved when others are added or removed."""

from __future__ import annotations

from zlib import crc32

import numpy as np

Bits = type[np.random.PCG64] | type[np.random.SFC64]


def stream(seed: int, run: int, *names: str | int, bits: Bits = np.random.SFC64) -> np.random.Generator:
    """Generator for one named source of randomness of one run; the same arguments give the same stream.

    ``SeedSequence(seed, spawn_key=(run, *keys))``, a name's key its CRC-32. bits : data sets hold effects drawn from
    PCG64 and all else from SFC64; either must stay, or the same seed would give other data.
    """
    keys = tuple(crc32(name.encode()) if isinstance(name, str) else name for name in names)
    return np.random.Generator(bits(np.random.SeedSequence(seed, spawn_key=(run, *keys))))
