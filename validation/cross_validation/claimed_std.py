"""Claimed standard deviations of the offset, compared with the scatter when legs are left out in turn."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from scipy.special import gammaincinv

from calib import CALIBRATORS, Calibration, Reference
from calib.held_out.legs import LegPartition, legs_of
from calib.models.response import strength_columns
from calib.numerics.points import lengths
from calib.numerics.rates import world_to_body
from calib.options import SEPARATOR
from recordings import Recording
from scenarios.arrays import Array
from validation.text import figure

MOST = 1.5
"""Ratio of scatter to claim below which no remark is made."""
TURNED = "S_yx"
"""Parameter of fits that estimate the sensor's rotation, from attitude and field vector."""
SMALLEST = 1e-14
"""Eigenvalue of the scaled normal matrix below which a direction is rounding."""
FULL = 1.0 - 1e-6
"""Largest share of a direction's information in a single leg; a share of 1 leaves no residual."""
CHANCE = 0.99
"""Probability that white noise scatters less than the limit."""


@dataclass(frozen=True)
class Claim:
    """Rms over the axes of the offset's scatter over the claimed standard deviation, and the number of legs.

    limit : 99 % quantile of the ratio for white noise
    """

    ratio: float
    limit: float
    legs: int

    @property
    def sentence(self) -> str:
        """Return the meaning in a sentence, "" for a sound claim."""
        times = figure(self.ratio, 2)
        what = f"the offset scatters {times} times as much as claimed, by {self.legs} legs"
        if self.ratio <= MOST:
            return ""
        if self.ratio <= self.limit:
            return f"{what}; with so few legs white noise may explain a ratio of up to {figure(self.limit, 2)}"
        return f"{what}: the noise is not white, or the model is incomplete; multiply the claim by {times}"


def claim_of(fit: Calibration, recording: Recording, reference: Reference, legs: LegPartition) -> Claim | None:
    """Return a fit's claim against the scatter by legs; None without a claim, and for other models.

    var b = N^-1 (sum_j g_j g_j^T) N^-1,  g_j = J_j^T (1 - J_j N^-1 J_j^T)^(-1/2) r_j,  N = sum_j J_j^T J_j

    Unbiased in white noise for any weights of the legs [BellMcCaffrey2002]; the limit is that of a chi-squared
    distribution of equal mean and variance.
    """
    claimed = fit.offset_covariance_nT2
    if claimed is None or fit.eddy_s is not None or fit.segments or fit.status.kind != "ok":
        return None
    field_nT = fit.apply(recording)
    rows = lambda block: _rows(fit, recording.taken(block), field_nT[block], reference)  # noqa: E731
    scatter, each = _by_legs(legs.squares(rows))
    std = np.sqrt(np.diag(each.sum(axis=0)))
    free = 9.0 / float(np.sum((each / np.outer(std, std)) ** 2))
    limit = float(np.sqrt(2.0 * gammaincinv(free / 2.0, CHANCE) / free))
    return Claim(float(np.sqrt(np.mean(np.diag(scatter) / np.diag(claimed)))), limit, legs.count)


def claims_of(fits: Mapping[str, Calibration], recording: Recording, reference: Reference) -> dict[str, Claim]:
    """Return the claims of magbench's batch calibrators for a single magnetometer, by key of the fit."""
    if recording.array_mag_nT is not None:
        return {}
    methods = {name: CALIBRATORS.get(name.partition(SEPARATOR)[0]) for name in fits}
    batch = {name: method for name, method in methods.items() if method is not None and not method.sequential}
    alone = [name for name, method in batch.items() if not {"gyro", "scalar"} & set(method.needs)]
    parts = {name: fits[name].used(recording) for name in alone}
    found = {name: claim_of(fits[name], part, reference, legs_of(part)) for name, part in parts.items()}
    return {name: claim for name, claim in found.items() if claim is not None}


def _by_legs(squares: Array) -> tuple[Array, Array]:
    """Return the covariance (3, 3) of the offset by legs, and each leg's part (legs, 3, 3) for unit white noise.

    squares (legs, k + 1, k + 1) : of the columns and the residual
    """
    total = squares.sum(axis=0)[:-1, :-1]
    size = np.sqrt(np.diag(total))
    values, axes = np.linalg.eigh(total / np.outer(size, size))
    root = axes / np.sqrt(values.clip(SMALLEST)) / size[:, None]
    own = np.einsum("ki,lkm,mj->lij", root, squares[:, :-1, :-1], root, optimize=True)
    share, along = np.linalg.eigh(own)
    slope = np.einsum("lik,li->lk", along, squares[:, :-1, -1] @ root) / np.sqrt(1.0 - share.clip(0.0, FULL))
    moved = np.einsum("lik,lk->li", along, slope) @ root[:3].T
    return moved.T @ moved, np.einsum("ai,lij,bj->lab", root[:3], own, root[:3], optimize=True)


def _rows(fit: Calibration, recording: Recording, field_nT: Array, reference: Reference) -> Array:
    """Return columns of offset and S about the fit, and the residual in nT of the measurement (n, r, k + 1).

    field_nT (n, 3) : as the fit corrects the recording
    """
    if TURNED in fit.covariance_names:
        assert recording.att_q is not None
        known = world_to_body(recording.att_q, np.array(reference.field_enu_nT))
        x = np.column_stack([np.ones(len(known)), known / reference.strength_nT])
        columns = np.einsum("nj,ab->najb", x, np.eye(3)).reshape(len(x), 3, 12)
        return np.concatenate([columns, ((field_nT - known) @ np.linalg.inv(fit.matrix).T)[:, :, None]], axis=2)
    a, J, _ = strength_columns(fit, field_nT, reference.strength_nT)
    rows = np.column_stack([J, lengths(field_nT) - reference.strength_nT])
    return np.asarray(rows / lengths(a)[:, None])[:, None, :]
