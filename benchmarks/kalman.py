"""The Kalman calibrators against filterpy's own predict and update on the same samples."""

from __future__ import annotations

import numpy as np
from filterpy.kalman import KalmanFilter

from benchmarks.measure import Call, Row, paired_ratio
from calib import CALIBRATORS, Reference
from calib.models.vector import VectorData
from recordings import Recording
from scenarios.arrays import Array

MOST_RATIO = 0.12
"""Measured 0.09 to 0.10; 1.6 us of a sample are the filter, 0.8 us the checks, attitudes and residual."""
FIELD_ENU_NT = (-1940.0, 31916.0, -41285.0)
CASES = ("kalman", "kalman_rescaled", "kalman_fuzzy")
SAMPLES, SMALL = 5000, 200
"""Length of the recording; the second is for a test of the benchmark."""


def rows(small: bool = False) -> list[Row]:
    """Return a row for each filter."""
    recording, reference = turning(SMALL if small else SAMPLES), Reference.of_vector(FIELD_ENU_NT)
    bare = bare_steps(VectorData.of(recording, reference))
    return [_row(name, recording, reference, bare) for name in CASES]


def _row(name: str, recording: Recording, reference: Reference, bare: Call) -> Row:
    method = CALIBRATORS[name]()
    ratio, ours, theirs = paired_ratio(lambda: method.fit(recording, reference), bare)
    n = len(recording)
    note = f"{n} samples: filterpy {1e6 * theirs / n:.1f} us, {name} {1e6 * ours / n:.1f} us a sample"
    return Row(f"{name} / filterpy's own step", ratio, MOST_RATIO, False, note)


def bare_steps(data: VectorData) -> Call:
    """Filterpy's predict and update on every sample, nothing else."""
    H, y = data.observation(1000.0), data.difference_nT

    def steps() -> None:
        filter_ = KalmanFilter(dim_x=21, dim_z=3)
        filter_.x, filter_.P, filter_.Q, filter_.R = np.zeros(21), np.eye(21) * 100, np.eye(21) * 1e-5, np.eye(3) * 1e-3
        for k in range(len(y)):
            filter_.predict()
            filter_.update(y[k], H=H[k])

    return steps


def turning(samples: int) -> Recording:
    """A recording that turns about all axes, with 5 nT of noise."""
    time_s = 0.02 * np.arange(samples, dtype=np.float64)
    axes = np.sin(np.outer(time_s, [0.31, 0.23, 0.17])) * 2.0
    half = np.linalg.norm(axes, axis=1)[:, None] / 2
    att_q = np.concatenate((np.cos(half), np.sinc(half / np.pi) * axes / 2), axis=1)
    noise_nT: Array = np.random.default_rng(0).normal(0.0, 5.0, (samples, 3))
    turned = VectorData.of(Recording(time_s, noise_nT, att_q=att_q), Reference.of_vector(FIELD_ENU_NT))
    return Recording(time_s, 1.1 * turned.field_nT + [40.0, -100.0, 120.0] + noise_nT, att_q=att_q)
