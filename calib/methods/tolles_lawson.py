"""Tolles-Lawson compensation of a scalar magnetometer by a vector one beside it."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar, Literal

import numpy as np

from calib.base import Calibrator
from calib.models.scalar_terms import CHANNEL, HIGH, LOW, NAMES, REDUNDANT, STRENGTH, directions, terms
from calib.numerics.bands import AIRBORNE_HZ, band_passed, low_passed, manoeuvre_band
from calib.numerics.held_out import BlockSquares
from calib.numerics.noise import white_noise_std
from calib.numerics.paired import counted, mean_interval
from calib.reference import Reference
from calib.result import Calibration, Status
from calib.settings import Band, NotNegative
from recordings import Recording
from scenarios.arrays import Array

MOST_BLOCKS, LEAST_BLOCKS = 20, 6
"""Blocks held out in turn; of fewer than six the interval of the gain is wider than twice the spread of a block."""
PERIODS = 0.5
"""Length of a block at least, in periods of the band's lower edge; the filter remembers a sixth of a period."""
LEAST_GAIN = 1.5
"""Strength before over after compensation, on held-out blocks, from which a fit matters. In 500 simulated flights
(manoeuvres on four headings and plain lines, half of each recording or a leg held back) none of 176 without a
vehicle's field was ok, and 2 of 264 that were ok made the held-back strength worse in their band."""
TINY_NT = 1e-12


@dataclass(frozen=True)
class TollesLawsonCalibrator(Calibrator):
    """16 or 18 coefficients of the vehicle's field along the Earth's, see `calib.models.scalar_terms`.

    Both sides pass the band `band_hz`, which takes out the Earth's own changes along the line; by default the band of
    the manoeuvre, `calib.numerics.bands`. The coefficients follow by ridge regression, `ridge` in units of the squared
    length of a column, by default the ridge that predicts held-out blocks best. Status ok needs a compensated strength
    that is better than the raw one on blocks that neither coefficients nor ridge have seen; else every term is 0, with
    the standard deviation of what the log can determine.

    The recording needs the scalar magnetometer as the channel `scalar_nT`. The coefficients belong to the place of the
    scalar sensor, so offset and matrix of the vector sensor stay raw (the identity); `scalar_terms.compensated` gives
    the corrected strength. The vector sensor's own errors stay in it, and the second order of the vehicle's field,
    |dT|^2 / 2F.
    """

    name: ClassVar[str] = "tolles_lawson"
    summary: ClassVar[str] = "Tolles-Lawson terms of a scalar magnetometer (channel scalar_nT) beside the vector one"
    needs: ClassVar[tuple[str, ...]] = ("scalar",)
    min_samples: ClassVar[int] = 64
    sequential: ClassVar[bool] = True
    terms: Literal[16, 18] = 16
    band_hz: Band | None = None
    ridge: NotNegative | None = None

    def _solve(self, recording: Recording, reference: Reference, rng: np.random.Generator) -> Calibration | Status:
        names = tuple(n for n in NAMES if self.terms == 18 or n not in REDUNDANT)
        band_hz = self.band_hz or _band_hz(recording)
        length_s = float(recording.time_s[-1] - recording.time_s[0])
        blocks = min(MOST_BLOCKS, int(length_s * band_hz[0] / PERIODS))
        if blocks < LEAST_BLOCKS:
            return Status("unobservable", _too_short(length_s, band_hz))
        columns = terms(recording, reference.strength_nT)[:, [NAMES.index(n) for n in names]]
        sides = _Sides(columns, recording.channels[CHANNEL], recording.time_s, band_hz, blocks)
        told = {STRENGTH: reference.strength_nT, "noise_std_nT": float(white_noise_std(recording.mag_nT).max())}
        return self._fitted(sides, names, told)

    def _fitted(self, sides: _Sides, names: tuple[str, ...], told: dict[str, float]) -> Calibration:
        """The terms of all blocks, or 0 where held-out blocks do not bear them out."""
        squares = sides.squares(sides.band_hz)
        before_nT, after_nT, gained = self._gain(squares, sides)
        ridge = squares.chosen_ridge() if self.ridge is None else self.ridge
        solution, covariance = squares.solution(ridge)
        found = dict(zip(names, (solution if gained else 0.0 * solution).tolist(), strict=True))
        results = {
            LOW: sides.band_hz[0],
            HIGH: sides.band_hz[1],
            "ridge": ridge,
            "raw_rms_nT": before_nT,
            "held_out_rms_nT": after_nT,
            "improvement_ratio": before_nT / max(after_nT, TINY_NT),
            "condition_number": squares.condition,
        }
        return Calibration(
            name=self.name,
            status=Status("ok") if gained else _not_seen(before_nT, after_nT, sides),
            parameters=found | told | results,
            covariance=covariance,
            covariance_names=names,
        )

    def _gain(self, squares: BlockSquares, sides: _Sides) -> tuple[float, float, bool]:
        """Held-out rms before and after, nT, and whether the gain is significant and matters.

        Each block's ridge is chosen by the others. The gain must be significant too in the band of airborne
        surveys, which anomalies are read in.
        """
        count = len(squares.rows)
        ridges = [squares.chosen_ridge(j) if self.ridge is None else self.ridge for j in range(count)]
        found = squares.of_others(np.array(ridges))
        before_nT, after_nT = squares.whole(squares.raw_rms), squares.whole(squares.rms(found))
        matters = before_nT > LEAST_GAIN * after_nT and _log_gain(squares, found)[0] > 0
        elsewhere = matters and _log_gain(sides.squares(AIRBORNE_HZ, squares.size), found)
        return before_nT, after_nT, bool(elsewhere and elsewhere[0] > 0)


def _log_gain(squares: BlockSquares, parameters: Array) -> tuple[float, float]:
    """95 % interval of the mean logarithm of the blocks' rms before over after."""
    before, after = squares.raw_rms, squares.rms(parameters)
    least = 1e-12 * float(before.max()) or 1.0
    gain = np.log(before.clip(least) / after.clip(least))
    return mean_interval(gain, counted(gain[:, None]))


@dataclass(frozen=True, eq=False)
class _Sides:
    """Columns (n, k) and target (n,) of the regression; the columns are used below the upper edge of `band_hz`."""

    columns: Array
    target: Array
    time_s: Array
    band_hz: tuple[float, float]
    blocks: int

    def squares(self, band_hz: tuple[float, float], size: Array | None = None) -> BlockSquares:
        """Sums of squares of both sides in a band; in another one than `band_hz` the columns are low-passed too."""
        columns = self.columns if band_hz == self.band_hz else low_passed(self.columns, self.time_s, self.band_hz)
        passed = band_passed(np.column_stack((columns, self.target)), self.time_s, band_hz)
        return BlockSquares.of(passed[:, :-1], passed[:, -1], self.blocks, size)


def _band_hz(recording: Recording) -> tuple[float, float]:
    """The manoeuvre's band by the direction of the measured field, from a frequency that allows LEAST_BLOCKS."""
    u = directions(recording)
    low, high = manoeuvre_band(u, recording.time_s, float(white_noise_std(u).max()))
    return max(low, 1.01 * LEAST_BLOCKS * PERIODS / float(np.ptp(recording.time_s))), high


def _too_short(length_s: float, band_hz: tuple[float, float]) -> str:
    least_s = LEAST_BLOCKS * PERIODS / band_hz[0]
    return (
        f"{length_s:.3g} s are too short to hold parts out in the band {_edges(band_hz)}: record {least_s:.3g} s or "
        "more of pitch, roll and yaw manoeuvres, or give a higher band_hz"
    )


def _not_seen(before_nT: float, after_nT: float, sides: _Sides) -> Status:
    reason = (
        f"the vehicle's field is below what this log can determine: on {sides.blocks} held-out parts the strength is "
        f"off by {before_nT:.3g} nT rms raw and {after_nT:.3g} nT compensated, {_edges(sides.band_hz)}; every term is "
        "0; leave the strength as measured, or fly stronger pitch, roll and yaw manoeuvres on four headings"
    )
    return Status("unobservable", reason)


def _edges(band_hz: tuple[float, float]) -> str:
    return f"{band_hz[0]:.3g} to {band_hz[1]:.3g} Hz"
