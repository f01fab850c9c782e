"""Scores of a calibration against truth and hold-out motions, each with its unit."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from calib import Calibration
from recordings import Recording
from scenarios.arrays import Array
from validation.scoring.hold_out import MANOEUVRE_SAMPLES, HoldOut, HoldOutMotion
from validation.signals.amplitude import rms

CHI2_3_95 = 7.814727903251179
"""95 % point of chi-square with three degrees of freedom."""


@dataclass(frozen=True)
class Score:
    """Value of a score of a fit; in-sample scores are shown but never rank.

    rotation_removed : the rotation not determined by the field strength was removed first.
    """

    name: str
    value: float
    unit: str
    in_sample: bool = False
    rotation_removed: bool = False


def score(calibration: Calibration, recording: Recording, truth: HoldOut, attitude_free: bool) -> list[Score]:
    """Return all scores of a calibration; status "not_applicable" has `failure` and `wall_time` only.

    ===========================  ====  ==========================================================================
    offset_error                 nT    |offset - b|
    offset_error_axis_rms        nT    offset_error / sqrt(3): rms of the three axes
    offset_inside_95                   1 when b lies in the claimed 95 % ellipsoid; only with a claimed covariance
    offset_nees                        error' C^-1 error by the claimed covariance C; mean 3 for true claims
    matrix_error                       Frobenius norm of Q matrix S - I
    holdout_sphere_norm_rms      nT    rms of |h_cal| - |h|, all attitudes
    holdout_sphere_component_rms nT    rms length of Q h_cal - h over sqrt(3), all attitudes
    holdout_level_norm_rms       nT    as above, a level survey
    holdout_level_component_rms  nT
    heading_rms                  deg   heading by Q h_cal and true tilt, against truth, a level survey
    anomaly_rms                  nT    total-field anomaly of a dipole along a wobbling survey line, against truth
    figure_of_merit              nT    sum of the twelve manoeuvres' peak-to-peak of |h_cal| [Sheriff2002]
    failure                            1 when the status is not ok
    iterations                         length of the convergence history
    wall_time                    s
    in_sample_norm_rms           nT    rms of |h_cal| - F on the recording itself; ranks nothing
    ===========================  ====  ==========================================================================

    Q is I; for an attitude-free method, the rotation that fits matrix S to I best, since the field strength does not
    determine a rotation of the sensor. The heading is then the heading after an alignment of compass and vehicle.
    """
    always = [Score("failure", float(calibration.status.kind != "ok"), ""), Score("wall_time", calibration.wall_s, "s")]
    if calibration.status.kind == "not_applicable":
        return always
    turn = unobservable_rotation(calibration.matrix @ truth.matrix) if attitude_free else np.eye(3)
    return [
        *_offset_scores(calibration, truth),
        *_turned_scores(calibration, truth, turn, attitude_free),
        Score("anomaly_rms", anomaly_rms_nT(calibration, truth), "nT"),
        Score("figure_of_merit", figure_of_merit_nT(calibration, truth), "nT"),
        always[0],
        Score("iterations", float(len(calibration.history)), ""),
        always[1],
        Score("in_sample_norm_rms", in_sample_norm_rms_nT(calibration, recording, truth), "nT", in_sample=True),
    ]


def unobservable_rotation(total: Array) -> Array:
    """Return the rotation Q (3, 3) that minimises |Q total - I|_F (orthogonal Procrustes): V U^T of total = U D V^T."""
    u, _, vt = np.linalg.svd(total)
    proper = np.diag([1.0, 1.0, np.sign(np.linalg.det(u @ vt))])
    return np.asarray(vt.T @ proper @ u.T)


def _offset_scores(calibration: Calibration, truth: HoldOut) -> list[Score]:
    error_nT = calibration.offset_nT - truth.offset_nT
    length_nT = float(np.linalg.norm(error_nT))
    scores = [Score("offset_error", length_nT, "nT"), Score("offset_error_axis_rms", length_nT / math.sqrt(3.0), "nT")]
    covariance_nT2 = calibration.offset_covariance_nT2
    if covariance_nT2 is not None:
        distance = float(error_nT @ np.linalg.pinv(covariance_nT2, hermitian=True) @ error_nT)
        scores += [Score("offset_inside_95", float(distance <= CHI2_3_95), ""), Score("offset_nees", distance, "")]
    return scores


def _turned_scores(calibration: Calibration, truth: HoldOut, turn: Array, free: bool) -> list[Score]:
    matrix_error = float(np.linalg.norm(turn @ calibration.matrix @ truth.matrix - np.eye(3)))
    scores = [Score("matrix_error", matrix_error, "", rotation_removed=free)]
    for name, data in (("sphere", truth.sphere), ("level", truth.level)):
        field_nT = calibration.static().apply(data.recording()) @ turn.T
        norm_nT = np.linalg.norm(field_nT, axis=1) - np.linalg.norm(data.true_nT, axis=1)
        scores += [
            Score(f"holdout_{name}_norm_rms", rms(norm_nT), "nT"),
            Score(f"holdout_{name}_component_rms", rms(field_nT - data.true_nT), "nT", rotation_removed=free),
        ]
    heading_deg = np.degrees(heading_error_rad(field_nT, truth.level))
    return [*scores, Score("heading_rms", rms(heading_deg), "deg", rotation_removed=free)]


def heading_error_rad(field_nT: Array, data: HoldOutMotion) -> Array:
    """Return the heading error (n,) of a compass with true tilt and corrected field (n, 3).

    The error is the horizontal angle in the world frame between R_wb times the corrected field and magnetic north.
    """
    east, north = np.einsum("nij,nj->in", data.R_wb[:, :2], field_nT)
    true_east, true_north = np.einsum("nij,nj->in", data.R_wb[:, :2], data.true_nT)
    return np.asarray(np.arctan2(east * true_north - north * true_east, east * true_east + north * true_north))


def anomaly_rms_nT(calibration: Calibration, truth: HoldOut) -> float:
    """Return the rms error of the total-field anomaly along the survey line, mean removed."""
    error_nT = np.linalg.norm(calibration.static().apply(truth.line.recording()), axis=1) - truth.line_anomaly_nT
    return rms(error_nT - error_nT.mean())


def figure_of_merit_nT(calibration: Calibration, truth: HoldOut) -> float:
    """Return the sum of peak-to-peak corrected total fields over rolls, pitches and yaws on four headings."""
    total_nT = np.linalg.norm(calibration.static().apply(truth.manoeuvres.recording()), axis=1)
    return float(np.ptp(total_nT.reshape(-1, MANOEUVRE_SAMPLES), axis=1).sum())


def in_sample_norm_rms_nT(calibration: Calibration, recording: Recording, truth: HoldOut) -> float:
    """Return the rms of |h_cal| - F over the finite samples of the fitted recording."""
    strength_nT = float(np.linalg.norm(truth.sphere.true_nT[0]))
    norm_nT = np.linalg.norm(calibration.apply(recording), axis=1)
    return rms(norm_nT[np.isfinite(norm_nT)] - strength_nT)
