"""Planar calibration: centre and ellipse in x and y, from a level turn of a rover, boat, car or vane."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from calib.acceptance import MAX_MISFIT_FRACTION
from calib.base import Calibrator
from calib.models.planar import Ellipse
from calib.numerics.colour import inflation
from calib.observability import MAX_STD_FRACTION, Extent, axis_text
from calib.reference import Reference
from calib.result import OFFSET_NAMES, STRENGTH_NAME, Calibration, Status
from calib.settings import Positive
from recordings import Recording
from scenarios.arrays import Array
from scenarios.text import figure

NAMES = (*OFFSET_NAMES[:2], "S_xx", "S_xy", "S_yy")
UPPER = np.triu_indices(2)
UPRIGHT = 0.95
"""Least cosine between the normal of the plane and the sensor's z."""
LEVEL_ALONE = "x and y alone are calibrated, for level headings: z is not determined"


@dataclass(frozen=True)
class Planar(Calibrator):
    """Offset and symmetric soft iron in x and y, by the ellipse with the least squared distances.

    p = S h + b,  |h| = H:  min over b, S of the sum of squared distances of p_i = (m_x, m_y) to the ellipse

    H is the horizontal part of the reference vector; where only the strength is known S has determinant 1 and the
    parameter `strength_nT` is H in that scale: the heading does not depend on H. The result leaves z unchanged.
    `most_thickness`: rms distance of the measurements from a plane, as a share of the ellipse's radius, up to which the
    motion counts as level. Claimed covariance: linearised, with the noise of the distances, scaled where the distances
    are coloured, as by waves and slopes. [Ahn2002]
    """

    name: ClassVar[str] = "planar"
    summary: ClassVar[str] = "centre and ellipse in x and y from a level turn; no attitude; z not determined"
    min_samples: ClassVar[int] = 8
    one_axis: ClassVar[bool] = True
    own_judgement: ClassVar[bool] = True
    most_thickness: Positive = 0.3

    def _solve(self, recording: Recording, reference: Reference, rng: np.random.Generator) -> Calibration | Status:
        unfit = self._not_level(Extent.of(recording.mag_nT))
        if unfit is not None:
            return unfit
        order = np.argsort(recording.time_s, kind="stable")
        ellipse = Ellipse.of(recording.mag_nT[order, :2])
        if ellipse is None:
            return Status("unobservable", "the measurements lie on no ellipse in x and y: make a whole level turn")
        return self._calibration(ellipse, _horizontal(reference) or ellipse.radius_nT)

    def _calibration(self, ellipse: Ellipse, horizontal_nT: float) -> Calibration:
        """The ellipse as offset and soft iron in x and y, S = root / H; the identity in z."""
        soft = ellipse.root / horizontal_nT
        units = np.array([1.0, 1.0, *[1.0 / horizontal_nT] * 3])
        covariance = inflation(ellipse.distance_nT) * ellipse.covariance * np.outer(units, units)
        values = [*ellipse.centre.tolist(), *soft[UPPER].tolist()]
        matrix = np.eye(3)
        matrix[:2, :2] = np.linalg.inv(soft)
        return Calibration(
            name=self.name,
            status=_status(ellipse, soft, covariance),
            offset_nT=np.array([*ellipse.centre, 0.0]),
            matrix=matrix,
            parameters=dict(zip(NAMES, values, strict=True))
            | {STRENGTH_NAME: horizontal_nT, "noise_std_nT": ellipse.noise_nT},
            covariance=covariance,
            covariance_names=NAMES,
        )

    def _not_level(self, extent: Extent) -> Status | None:
        """Not applicable unless the measurements lie near a plane, whose normal is near the sensor's z.

        The variances along the two longer axes add up to the squared radius of a whole turn.
        """
        radius_nT = float(np.sqrt(extent.variance[1:].sum()))
        if extent.thickness_nT > self.most_thickness * radius_nT:
            what = f"the measurements leave a plane by {figure(extent.thickness_nT)} nT rms"
            return Status("not_applicable", f"{self.name} needs a level turn, and {what}: take ellipsoid")
        if abs(extent.thinnest[2]) < UPRIGHT:
            what = f"needs a turn about the sensor's z axis, and this one is about {axis_text(extent.thinnest)}"
            return Status("not_applicable", f"{self.name} {what}: name the level axes x and y")
        return None


def _horizontal(reference: Reference) -> float | None:
    """Horizontal strength of the reference vector, nT; None without a vector, and where the vector is vertical."""
    if reference.field_enu_nT is None:
        return None
    east, north, _ = reference.field_enu_nT
    return float(np.hypot(east, north)) or None


def _status(ellipse: Ellipse, soft: Array, covariance: Array) -> Status:
    """Status by the misfit, and by the covariance of offset and S in the scale of the corrected field."""
    radius_nT = ellipse.radius_nT
    misfit_nT = float(np.median(np.abs(ellipse.distance_nT)))
    if misfit_nT > MAX_MISFIT_FRACTION * radius_nT:
        what = f"the measurements are {figure(misfit_nT)} nT from the ellipse, of {figure(radius_nT)} nT radius"
        return Status("not_converged", f"{what}: turn level, away from iron, and check the axes")
    variance, axes = np.linalg.eigh(covariance[:2, :2])
    worst_nT, where = float(np.sqrt(max(variance[-1], 0.0))), np.array([*axes[:, -1], 0.0])
    loose = float(np.sqrt(max(np.diag(covariance)[2:].max(), 0.0))) / float(np.sqrt(np.linalg.det(soft)))
    if worst_nT > MAX_STD_FRACTION * radius_nT or loose > MAX_STD_FRACTION:
        what = (
            f"the offset along {axis_text(where)} cannot be determined: its standard deviation is {figure(worst_nT)} nT"
        )
        share = 100 * worst_nT / radius_nT
        limit = f"{figure(share)} % of the horizontal field, the limit is {100 * MAX_STD_FRACTION:g} %"
        return Status("unobservable", f"{what} ({limit}); turn through a whole circle, level")
    return Status("ok", LEVEL_ALONE) if ellipse.settled else Status("not_converged", "the fit did not settle")
