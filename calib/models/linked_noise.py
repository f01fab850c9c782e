"""How noisy the gyro is beside the magnetometer, from the recording itself."""

from __future__ import annotations

import numpy as np
from scipy.optimize import minimize_scalar

from calib.models.chained import Linear
from calib.models.linked import LEAST_NOISE, LinkedEstimate, LinkedSamples

REACH, FURTHER, FURTHEST = 0.4, 4.0, 7.0
"""Of the ratio's logarithm: how far another is looked for at first, by what this grows where the best is at the edge,
and where that ends: three decades."""
INSIDE = 0.9
"""Of the reach: a best within it is no edge."""
RATIO_TOLERANCE = 0.01
"""Of the ratio's logarithm; thousands of links tell it to 0.02."""


def likeliest_ratio(link: LinkedSamples, found: Linear[LinkedEstimate]) -> float:
    """The ratio under which what the fit leaves is most likely, directions and parameters integrated out.

    (free) log C + log det A + log det H + 4 n log ratio, least: C the cost with all at their best, A and H the
    information of the directions and of the parameters, n the links; linear about the estimate. [PattersonThompson1971]
    The present ratio where nothing is left to tell it from.
    """
    if found.least <= link.free * LEAST_NOISE**2:
        return link.ratio
    reach = REACH

    def unlikely(change: float) -> float:
        return unlikeliness(link.with_ratio(link.ratio * float(np.exp(change))), found)

    while True:
        best = minimize_scalar(unlikely, bounds=(-reach, reach), method="bounded", options={"xatol": RATIO_TOLERANCE})
        if abs(best.x) < INSIDE * reach or reach > FURTHEST:
            return link.ratio * float(np.exp(best.x))
        reach *= FURTHER


def unlikeliness(link: LinkedSamples, found: Linear[LinkedEstimate]) -> float:
    """-2 log of the likelihood of the link's noises, but for a constant, see `likeliest_ratio`."""
    again = link.linear(found.estimate)
    normal = link.normal(again)
    square = normal.square / np.outer(normal.scale, normal.scale)
    slope = normal.slope / normal.scale
    gained = float(slope @ np.linalg.lstsq(square, slope, rcond=None)[0])
    cost = max(normal.cost - gained, link.free * LEAST_NOISE**2)
    parameters = float(np.linalg.slogdet(square)[1] + 2.0 * np.log(normal.scale).sum())
    return link.free * float(np.log(cost)) + again.logarithm + parameters + 4.0 * link.links * float(np.log(link.ratio))
