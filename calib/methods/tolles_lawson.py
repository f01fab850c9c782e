"""Tolles-Lawson compensation of a scalar magnetometer by a vector one beside it."""

from __future__ import annotations

from dataclasses import dataclass, replace
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
from scenarios.text import figure

MOST_BLOCKS, LEAST_BLOCKS = 20, 6
"""Blocks held out in turn; of fewer than six the interval of the gain is wider than twice the spread of a block."""
PERIODS = 0.5
"""Length of a block at least, in periods of the band's lower edge; the filter remembers a sixth of a period."""
LEAST_GAIN = 1.5
"""Strength before over after compensation, on held-out blocks, from which a fit matters. In 500 simulated flights
(manoeuvres on four headings and plain lines, half of each recording or a leg held back) none of 176 without a
vehicle's field was ok."""
MOST_ERROR = 0.2
"""Standard deviation of the vehicle's field on other headings, over that field's rms, up to which a fit is ok. Of 400
simulated flights with a vehicle's field of 0.3 to 10 nT, half of each or a leg held back, 8 of 158 fits without this
limit and that of QUARTERS made a leg of the held-back part worse, by up to 3.3 times; of 500 others with the limits
none of 88, the worst to 0.64. With 0.4 instead 3 of 135, by up to a fifth."""
QUARTERS = 4
"""Long parts of the log, each of which the terms of the others must not make worse."""
HEADINGS = 4
"""Quarter turns about the body's z to which the log's motion is turned."""
TINY_NT = 1e-12


@dataclass(frozen=True)
class TollesLawsonCalibrator(Calibrator):
    """16 or 18 coefficients of the vehicle's field along the Earth's, see `calib.models.scalar_terms`.

    Both sides pass the band `band_hz`, which takes out the Earth's own changes along the line; by default the band of
    the manoeuvre, `calib.numerics.bands`. The coefficients follow by ridge regression, `ridge` in units of the squared
    length of a column, by default the ridge that predicts held-out blocks best. Status ok needs a compensated strength
    that is better than the raw one on blocks that neither coefficients nor ridge have seen, and terms that determine
    the vehicle's field on headings that the log may lack; else every term is 0, with
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
        which = [NAMES.index(n) for n in names]
        columns = terms(recording, reference.strength_nT)[:, which]
        sides = _Sides(columns, recording.channels[CHANNEL], recording.time_s, band_hz, blocks)
        turned = tuple(terms(one, reference.strength_nT)[:, which] for one in _headings(recording))
        told = {STRENGTH: reference.strength_nT, "noise_std_nT": float(white_noise_std(recording.mag_nT).max())}
        return self._fitted(sides, turned, names, told)

    def _fitted(
        self, sides: _Sides, turned: tuple[Array, ...], names: tuple[str, ...], told: dict[str, float]
    ) -> Calibration:
        """The terms of all blocks, or 0 where held-out blocks or columns of other headings do not bear them out."""
        squares = sides.squares(sides.band_hz)
        before_nT, after_nT, gained = self._gain(squares, sides)
        ridge = squares.chosen_ridge() if self.ridge is None else self.ridge
        solution, covariance = squares.solution(ridge)
        error = max(_error(sides.passed(columns), solution, covariance) for columns in turned) if gained else 0.0
        status = _status(before_nT, after_nT, error, sides, gained=gained)
        gained = status.kind == "ok"
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
            status=status,
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
        if not matters:
            return before_nT, after_nT, False
        airborne = sides.squares(AIRBORNE_HZ, squares.size)
        sure = _log_gain(airborne, found)[0] > 0 and _no_part_loses(squares, airborne, self.ridge)
        return before_nT, after_nT, sure


def _no_part_loses(squares: BlockSquares, airborne: BlockSquares, ridge: float | None) -> bool:
    """Whether the terms of the other quarters make no quarter worse, in either band."""
    quarters = squares.merged(QUARTERS)
    found = quarters.of_others(np.full(QUARTERS, squares.chosen_ridge() if ridge is None else ridge))
    return all(bool((one.rms(found) <= one.raw_rms).all()) for one in (quarters, airborne.merged(QUARTERS)))


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

    def passed(self, columns: Array) -> Array:
        """Columns (n, k) as the compensation uses them, in `band_hz`."""
        return band_passed(low_passed(columns, self.time_s, self.band_hz), self.time_s, self.band_hz)


def _headings(recording: Recording) -> list[Recording]:
    """The recording, and its motion turned to the other headings: u about the body's z."""
    angles = np.pi / 2 * np.arange(HEADINGS)
    turns = [np.array([[np.cos(a), -np.sin(a), 0.0], [np.sin(a), np.cos(a), 0.0], [0.0, 0.0, 1.0]]) for a in angles]
    return [replace(recording, mag_nT=recording.mag_nT @ turn.T) for turn in turns]


def _error(columns: Array, solution: Array, covariance: Array) -> float:
    """Standard deviation of the vehicle's field X c over its rms: sqrt(tr(N V) / c^T N c),  N = X^T X."""
    N = columns.T @ columns
    return float(np.sqrt(np.sum(N * covariance) / max(float(solution @ N @ solution), TINY_NT)))


def _band_hz(recording: Recording) -> tuple[float, float]:
    """The manoeuvre's band by the direction of the measured field, from a frequency that allows LEAST_BLOCKS."""
    u = directions(recording)
    low, high = manoeuvre_band(u, recording.time_s, float(white_noise_std(u).max()))
    return max(low, 1.01 * LEAST_BLOCKS * PERIODS / float(np.ptp(recording.time_s))), high


def _too_short(length_s: float, band_hz: tuple[float, float]) -> str:
    least_s = LEAST_BLOCKS * PERIODS / band_hz[0]
    return (
        f"{figure(length_s)} s are too short to hold parts out in the band {_edges(band_hz)}: record "
        f"{figure(least_s)} s or "
        "more of pitch, roll and yaw manoeuvres, or give a higher band_hz"
    )


def _status(before_nT: float, after_nT: float, error: float, sides: _Sides, *, gained: bool) -> Status:
    """Ok for a gain on held-out blocks, and an error on other headings of a part of the vehicle's field at most."""
    if not gained:
        return _not_seen(before_nT, after_nT, sides)
    if error <= MOST_ERROR:
        return Status("ok")
    reason = (
        f"on other headings the vehicle's field is known to {figure(100.0 * error, 2)} % only (limit "
        f"{100.0 * MOST_ERROR:g} "
        "%): a leg elsewhere may get worse; every term is 0; fly pitch, roll and yaw manoeuvres on four headings"
    )
    return Status("unobservable", reason)


def _not_seen(before_nT: float, after_nT: float, sides: _Sides) -> Status:
    what = "the vehicle's field is below what this log can determine"
    if before_nT > LEAST_GAIN * after_nT:
        what = "the terms of most of this log make other parts of it worse, or not surely better"
    reason = (
        f"{what}: on {sides.blocks} held-out parts the strength is off by {figure(before_nT)} nT rms raw and "
        f"{figure(after_nT)} nT compensated, {_edges(sides.band_hz)}; every term is 0; leave the strength as "
        "measured, or "
        "fly stronger pitch, roll and yaw manoeuvres on four headings"
    )
    return Status("unobservable", reason)


def _edges(band_hz: tuple[float, float]) -> str:
    return f"{figure(band_hz[0])} to {figure(band_hz[1])} Hz"
