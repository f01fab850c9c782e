"""Maximum likelihood with directions linked by the gyro, for vehicles that cannot tumble."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

from calib.families.gyro_linked import GyroLinked, LinkedFit
from calib.reference import Reference
from recordings import Recording


@dataclass(frozen=True)
class GyroMl(GyroLinked):
    """Offset and S of greatest likelihood, the field's direction carried from sample to sample by the gyro.

    m_i = S F u_i + b + n_i,  u_(i+1) = exp(-[(omega_i - beta) dt_i]x) u_i + w_i,  |u_i| = 1

    All directions u_i, b, S and the gyro's bias beta at once, by damped Gauss-Newton, in time in proportion to the
    samples: the directions are eliminated along the chain and found again backwards. omega_i is the mean over a step of
    the cubic through four rates; a gap in the recording cuts the chain. S has nine entries, in the gyro's axes: with
    rates about changing axes the gyro tells the sensor's turn against it, at hardly any cost to the offset.

    n is white, and w white of standard deviation `gyro_std_rad_s` dt_i. The noise of n is fitted, that of the gyro too
    where it is None: the ratio of both is the one under which what the fit leaves is most likely
    [PattersonThompson1971], so that a gyro that is worse than its white noise counts for less.
    Started from the sphere, the algebraic ellipsoid and the linear fit of T m_j - d = R_ij (T m_i - d) along the gyro's
    rotations R_ij, each turned to where the gyro's axes are seen to be, in order of cost until one settles.
    Claimed covariance: inverse information, the directions and the bias not known. [RauchTungStriebel1965]

    `aligned` True: S symmetric, the gyro along the axes in which it is.
    """

    name: ClassVar[str] = "gyro_ml"
    summary: ClassVar[str] = "maximum likelihood with directions linked by the gyro, for vehicles that cannot tumble"
    needs: ClassVar[tuple[str, ...]] = ("gyro",)

    @property
    def _beside(self) -> tuple[str, ...]:
        return ()

    def _refined(self, fit: LinkedFit, recording: Recording, reference: Reference) -> LinkedFit:
        """As it is."""
        return fit
