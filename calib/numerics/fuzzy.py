"""A Mamdani controller of three rules: from a ratio near one to a correction factor near one."""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache
from typing import Annotated

import numpy as np
from pydantic import Field

from calib.settings import Positive, check
from scenarios.arrays import Array

GRID = 401
"""Points on which the aggregated output set is held, and of the tabulated surface."""


@dataclass(frozen=True)
class MamdaniRatio:
    """s(ROR) by three rules: equal -> medium, small -> small, large -> large ([Li2017] eq. 16, figure 1).

    The paper prints no numbers for the sets; here, w = `width` and d = `gain`:

        ROR: small, 1 below 1 - w, falling to 0 at 1;  equal, triangle (1 - w, 1, 1 + w);  large, mirror of small
        s:   triangles small (1 - 2d, 1 - d, 1), medium (1 - d, 1, 1 + d), large (1, 1 + d, 1 + 2d)

    Each rule cuts its output set at the membership of the ratio (minimum), the cut sets are united (maximum), and s is
    the centre of area of the union. So s(1) = 1 and 1 - d <= s <= 1 + d.
    """

    width: Positive = 0.5
    gain: Annotated[float, Field(gt=0, le=0.5)] = 0.02

    def __post_init__(self) -> None:
        """Raise InputError where a value is not what its type allows."""
        check(self, "rules")

    def memberships(self, ratio: Array) -> tuple[Array, Array, Array]:
        """Membership of ratios (n,) in small, equal, large."""
        lean = (ratio - 1.0) / self.width
        return np.clip(-lean, 0.0, 1.0), np.clip(1.0 - np.abs(lean), 0.0, 1.0), np.clip(lean, 0.0, 1.0)

    def factor(self, ratio: Array) -> Array:
        """Correction factor s (n,) of ratios (n,)."""
        s = np.linspace(1.0 - 2.0 * self.gain, 1.0 + 2.0 * self.gain, GRID)
        union = np.zeros((len(ratio), GRID))
        for degree, peak in zip(self.memberships(ratio), (-1.0, 0.0, 1.0), strict=True):
            triangle = np.clip(1.0 - np.abs(s - 1.0 - peak * self.gain) / self.gain, 0.0, 1.0)
            union = np.maximum(union, np.minimum(degree[:, None], triangle))
        return np.asarray((union @ s) / union.sum(axis=1))

    def table(self) -> list[float]:
        """s at GRID ratios evenly from 1 - w to 1 + w; it is constant beyond them."""
        return _table(self)


RULES = MamdaniRatio()


@lru_cache(maxsize=8)
def _table(rules: MamdaniRatio) -> list[float]:
    """Tabulated once, because the controller is asked at every sample."""
    return [float(s) for s in rules.factor(np.linspace(1.0 - rules.width, 1.0 + rules.width, GRID))]
