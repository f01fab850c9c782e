"""Size of a gap: rms of measured minus simulated before and after the named effects."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import astuple, dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from diagnosis.problem.linear import LinearProblem
from scenarios.arrays import Array
from validation.signals.amplitude import rms


@dataclass(frozen=True)
class GapSize:
    """Rms of measured minus simulated on held-out segments, with hard and soft iron refitted on the training segments.

    explained: ``(g0^2 - g1^2) / (g0^2 - 1)``, at most 1, g in units of the noise; None where there is no gap.
    """

    before_nT: float
    before_sigma: float
    after_nT: float
    after_sigma: float
    explained: float | None

    @property
    def noise_nT(self) -> float:
        """Noise of a sample."""
        return self.before_nT / self.before_sigma

    @property
    def structure_nT(self) -> tuple[float, float]:
        """Rms before and after beyond the noise: ``sqrt(rms^2 - noise^2)``."""
        before, after = (max(rms_nT**2 - self.noise_nT**2, 0.0) ** 0.5 for rms_nT in (self.before_nT, self.after_nT))
        return before, after

    def without_effects(self) -> GapSize:
        """The gap without named effects: nothing is explained."""
        explained = None if self.explained is None else 0.0
        return replace(self, after_nT=self.before_nT, after_sigma=self.before_sigma, explained=explained)

    def as_dict(self) -> dict[str, Any]:
        """The key `gap` of the JSON."""
        before = {"rms_nT": self.before_nT, "rms_sigma": self.before_sigma}
        after = {"rms_nT": self.after_nT, "rms_sigma": self.after_sigma}
        return {"before": before, "after": after, "explained": self.explained}

    @classmethod
    def joint(cls, gaps: Sequence[GapSize]) -> GapSize:
        """Size of several gaps with equal weight; the explained share counts recordings with a gap only."""
        with_gap = [gap for gap in gaps if gap.explained is not None]
        excess = sum(gap.before_sigma**2 - 1 for gap in with_gap)
        taken = sum(gap.before_sigma**2 - gap.after_sigma**2 for gap in with_gap)
        before_nT, before, after_nT, after = map(rms, zip(*(astuple(gap)[:4] for gap in gaps), strict=True))
        return cls(before_nT, before, after_nT, after, min(1.0, taken / excess) if with_gap else None)

    @classmethod
    def of(cls, problem: LinearProblem, before: Array, after: Array, use: NDArray[np.bool_]) -> GapSize:
        """The size of residuals before and after (n, q), in units of the noise, on the usable samples of `use` (n,)."""
        residuals = [residual[use & (problem.usable > 0)] for residual in (before, after)]
        before_sigma, after_sigma = map(rms, residuals)
        before_nT, after_nT = (rms(residual * problem.sigma_nT) for residual in residuals)
        excess = before_sigma**2 - 1
        is_gap = excess > problem.policy.hardly_any
        explained = min(1.0, (before_sigma**2 - after_sigma**2) / excess) if is_gap else None
        return cls(before_nT, before_sigma, after_nT, after_sigma, explained)
