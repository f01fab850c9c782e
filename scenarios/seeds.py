"""Random streams by name: independent of each other, and unchanged when streams are added or removed."""

from __future__ import annotations

from zlib import crc32

import numpy as np

Bits = type[np.random.PCG64] | type[np.random.SFC64]


def stream(seed: int, run: int, *names: str | int, bits: Bits = np.random.SFC64) -> np.random.Generator:
    """Return the generator of a named source of randomness in a run; equal arguments give equal streams.

    ``SeedSequence(seed, spawn_key=(run, *keys))``, the key of a name is the name's CRC-32. bits : PCG64 for effects,
    SFC64 for all else; a change of either would change the data of a seed.
    """
    keys = tuple(crc32(name.encode()) if isinstance(name, str) else name for name in names)
    return np.random.Generator(bits(np.random.SeedSequence(seed, spawn_key=(run, *keys))))
