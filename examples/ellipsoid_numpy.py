"""A calibrator of one's own in ten lines of numpy: `magbench calibrate log.csv --with examples.ellipsoid_numpy:fit`."""

import numpy as np


def fit(recording, reference):
    """Offset, nT, and matrix of an ellipsoid through the measurements, by algebraic least squares."""
    x, y, z = recording.mag_nT.T / reference.strength_nT
    one = np.ones_like(x)
    D = np.column_stack([x * x, y * y, z * z, 2 * x * y, 2 * x * z, 2 * y * z, 2 * x, 2 * y, 2 * z])
    a, b, c, d, e, f, *p = np.linalg.lstsq(D, one, rcond=None)[0]
    A = np.array([[a, d, e], [d, b, f], [e, f, c]])
    centre = -np.linalg.solve(A, p)
    size, axes = np.linalg.eigh(A / (1 + centre @ A @ centre))
    return reference.strength_nT * centre, axes @ np.diag(np.sqrt(size)) @ axes.T
