"""The 48 signed axis maps: 24 turns, and the same 24 with a reflection."""

from __future__ import annotations

from itertools import permutations, product

import numpy as np

from scenarios.arrays import Array


def _turns() -> Array:
    """Return the 24 maps (24, 3, 3) of determinant +1, the identity first."""
    maps = [
        np.diag(signs) @ np.eye(3)[list(order)]
        for order in permutations(range(3))
        for signs in product((1.0, -1.0), repeat=3)
    ]
    return np.array([one for one in maps if np.linalg.det(one) > 0])


TURNS = _turns()
"""Maps P of determinant +1; ``P m`` is in the body frame. The reflections are -P."""


def map_text(axes: Array) -> str:
    """Return a map (3, 3) as the log's axes that form x, y and z of the body, e.g. "y,x,-z"."""
    columns = np.abs(axes).argmax(axis=1)
    signs = axes[np.arange(3), columns]
    return ",".join(("-" if sign < 0 else "") + "xyz"[column] for sign, column in zip(signs, columns, strict=True))


def is_turn(axes: Array) -> bool:
    """Return whether a map keeps handedness."""
    return bool(np.linalg.det(axes) > 0)
