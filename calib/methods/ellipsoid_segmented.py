"""Ellipsoid fit in segments: an ellipsoid that moves during the record."""

from __future__ import annotations

import itertools
from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from calib.base import Calibrator
from calib.methods.ellipsoid import EllipsoidCalibrator
from calib.models.change_points import PARAMETERS, LinearisedRows, find_cuts
from calib.models.ellipsoid import SYMMETRIC_NAMES, symmetric
from calib.reference import Reference
from calib.result import OFFSET_NAMES, Calibration, Segment, Status
from calib.settings import Count, NotNegative, Positive
from recordings import Recording
from scenarios.arrays import Array

NAMES = (*OFFSET_NAMES, *SYMMETRIC_NAMES)


@dataclass(frozen=True)
class EllipsoidSegmented(Calibrator):
    """An `ellipsoid` fit to each segment of the record, for a hard iron that moves. [Zhang2018] section 3.1.

    m = S_k h + b_k for t in segment k, |h| = F

    The paper leaves the cuts open. `cuts_s` gives them as times; None lets the program choose: the whole-record fit is
    linearised, and dynamic programming over `blocks` blocks finds the cuts at which separate ellipsoids lower the
    squared radial residual, in units of its sample-to-sample noise, by more than `penalty` times Schwarz's
    criterion (see `calib.models.change_points`); no segment may leave its centre less certain than `max_std_fraction`
    of the field. Cuts that the exact fits do not bear out by the same criterion are then taken back. White noise is
    meant: coloured noise gives cuts, raise `penalty` there.
    `segments` of the result has b_k and S_k^-1, and `apply` switches by time. Its offset_nT and matrix, and their
    covariance, are those of the mean of b_k and S_k over all samples. The fit fails if a given segment cannot be
    determined.
    """

    name: ClassVar[str] = "ellipsoid_segmented"
    summary: ClassVar[str] = "an ellipsoid a segment, cuts given or found where the ellipsoid moves; no attitude"
    min_samples: ClassVar[int] = 10
    sequential: ClassVar[bool] = True
    cuts_s: tuple[float, ...] | None = None
    blocks: Count = 80
    penalty: NotNegative = 1.0
    max_std_fraction: Positive = 1e-3

    def _solve(self, recording: Recording, reference: Reference, rng: np.random.Generator) -> Calibration | Status:
        pieces = self._found(recording, reference) if self.cuts_s is None else self._given(recording, reference)
        return pieces if isinstance(pieces, Status) else self._together(recording, pieces)

    def _given(self, recording: Recording, reference: Reference) -> list[Piece] | Status:
        """Fits to the segments between the cuts asked for."""
        assert self.cuts_s is not None
        starts = np.searchsorted(recording.time_s, sorted(self.cuts_s)).tolist()
        if starts and not (starts[0] > 0 and starts[-1] < len(recording)):
            return Status(
                "not_applicable",
                f"cuts_s must lie between {recording.time_s[0]:g} and "
                f"{recording.time_s[-1]:g} s, found {', '.join(f'{t:g}' for t in sorted(self.cuts_s))}",
            )
        pieces = _fitted(recording, reference, list(dict.fromkeys(starts)))
        for k, piece in enumerate(pieces):
            if piece.fit.status.kind != "ok":
                return _failed(k + 1, len(pieces), recording, piece)
        return pieces

    def _found(self, recording: Recording, reference: Reference) -> list[Piece] | Status:
        """Fits to the segments that pay, or the status of a whole record that cannot be fitted."""
        whole = _piece(recording, reference, 0, len(recording))
        coloured = whole.fit.parameters.get("covariance_inflation", 1.0) > 1.0  # what cuts may take out
        if whole.fit.status.kind not in ("ok", "not_converged") and not coloured:
            return whole.fit.status
        rows = LinearisedRows.of(recording.mag_nT, whole.fit, reference.strength_nT)
        pieces = _fitted(recording, reference, find_cuts(rows, self.blocks, self.penalty, self.max_std_fraction))
        variance_nT2 = (rows.noise_std() * reference.strength_nT) ** 2
        price_nT2 = variance_nT2 * self.penalty * PARAMETERS * float(np.log(len(recording)))
        pieces = _borne_out(recording, reference, pieces, price_nT2)
        return pieces if len(pieces) > 1 or whole.fit.status.kind == "ok" else whole.fit.status

    def _together(self, recording: Recording, pieces: list[Piece]) -> Calibration:
        """The segments, and their mean over all samples."""
        fits = [piece.fit for piece in pieces]
        starts_s = [float(recording.time_s[piece.first]) for piece in pieces]
        share = np.array([piece.last - piece.first for piece in pieces]) / len(recording)
        values = share @ np.array([[fit.parameters[name] for name in NAMES] for fit in fits])
        told = {"noise_std_nT": _pooled_noise_nT(share, fits), "segments": float(len(fits))}
        return Calibration(
            name=self.name,
            status=Status("ok"),
            offset_nT=values[:3],
            matrix=np.asarray(np.linalg.inv(symmetric(values[3:]))),
            parameters=dict(zip(NAMES, values.tolist(), strict=True)) | told,
            covariance=_mean_covariance(share, fits),
            covariance_names=NAMES,
            history=tuple(itertools.chain.from_iterable(fit.history for fit in fits)),
            segments=tuple(Segment(t, fit.offset_nT, fit.matrix) for t, fit in zip(starts_s, fits, strict=True)),
        )


def _mean_covariance(share: Array, fits: list[Calibration]) -> Array:
    """Covariance (9, 9) of the mean of independent fits."""
    covariance = np.zeros((len(NAMES), len(NAMES)))
    for weight, fit in zip(share, fits, strict=True):
        assert fit.covariance is not None
        covariance += weight**2 * fit.covariance
    return covariance


def _pooled_noise_nT(share: Array, fits: list[Calibration]) -> float:
    return float(np.sqrt(share @ np.array([fit.parameters["noise_std_nT"] ** 2 for fit in fits])))


@dataclass(frozen=True)
class Piece:
    """The fit to the samples from first to before last."""

    first: int
    last: int
    fit: Calibration

    @property
    def cost_nT2(self) -> float:
        """Squared residual of the fit; infinite where there is none to use."""
        noise_nT = self.fit.parameters.get("noise_std_nT", np.inf)
        return float((self.last - self.first) * noise_nT**2) if self.fit.status.kind == "ok" else np.inf


def _piece(recording: Recording, reference: Reference, first: int, last: int) -> Piece:
    part = Recording(recording.time_s[first:last], recording.mag_nT[first:last])
    return Piece(first, last, EllipsoidCalibrator(robust=False).fit(part, reference))


def _fitted(recording: Recording, reference: Reference, starts: list[int]) -> list[Piece]:
    return [_piece(recording, reference, a, b) for a, b in itertools.pairwise([0, *starts, len(recording)])]


def _borne_out(recording: Recording, reference: Reference, pieces: list[Piece], price_nT2: float) -> list[Piece]:
    """Join neighbours, the least loss first, while two exact fits do not beat one by the price of a segment."""
    while len(pieces) > 1:
        joined = [_piece(recording, reference, a.first, b.last) for a, b in itertools.pairwise(pieces)]
        loss = [_loss_nT2(one, a, b) for one, (a, b) in zip(joined, itertools.pairwise(pieces), strict=True)]
        k = int(np.argmin(loss))
        if loss[k] > price_nT2:
            return pieces
        pieces = [*pieces[:k], joined[k], *pieces[k + 2 :]]
    return pieces


def _loss_nT2(joined: Piece, left: Piece, right: Piece) -> float:
    """Cost of one fit above that of two; none where a half cannot be determined."""
    if np.isinf(left.cost_nT2) or np.isinf(right.cost_nT2):
        return 0.0
    return joined.cost_nT2 - left.cost_nT2 - right.cost_nT2


def _failed(number: int, count: int, recording: Recording, piece: Piece) -> Status:
    status = piece.fit.status
    time_s = recording.time_s
    where = (
        f"segment {number} of {count} ({time_s[piece.first]:g} to {time_s[piece.last - 1]:g} s, "
        f"{piece.last - piece.first} samples)"
    )
    kind = "unobservable" if status.kind == "not_applicable" else status.kind
    return Status(kind, f"{where}: {status.reason}; or take fewer cuts")
