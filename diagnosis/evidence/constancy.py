"""Constancy test: the coefficients of a true effect are equal in all parts of a run."""

from __future__ import annotations

import numpy as np
from scipy.stats import chi2

from diagnosis.evidence.candidate_test import CandidateFit, ColouredBaseline
from diagnosis.evidence.hypothesis import information_by_part
from scenarios.arrays import Array

OPEN = 1e-6
"""Eigenvalue of a part's scaled information matrix below which a combination of coefficients is undetermined."""


def coefficients_change(candidate: CandidateFit, coloured_baseline: ColouredBaseline, share: float) -> bool:
    """Whether the parts of a run have significantly different coefficients, beyond an error of form.

    ``Q = sum_b g_b^T N_b^-1 g_b - g^T N^-1 g`` from information N_b (k, k) and score g_b (k,) of each part, and their
    sums N, g. Q is chi-square with the sum of the ranks of N_b less the rank of N. share : part of ``g^T N^-1 g`` that
    an error of form may add to Q.
    """
    policy = coloured_baseline.rows.policy
    parts = information_by_part(
        candidate.rows,
        coloured_baseline.accepted_columns,
        candidate.columns,
        candidate.hypothesis.noise_model,
        policy.scatter_parts,
    )
    (whole, known), each = _explained(np.sum(parts, axis=0)), [_explained(part) for part in parts]
    degrees = sum(rank for _, rank in each) - known
    Q = sum(squares for squares, _ in each) - whole
    by_chance = degrees == 0 or chi2.sf(Q, degrees) > policy.alpha
    return not by_chance and bool(Q - degrees > share * whole)


def _explained(products: Array) -> tuple[float, int]:
    """Squares that k columns explain, and their rank, from products (k + 1, k + 1) of columns and target."""
    size = np.sqrt(np.maximum(np.diag(products)[:-1], 1e-300))
    values, vectors = np.linalg.eigh(products[:-1, :-1] / np.outer(size, size))
    some = values > OPEN
    scores = vectors[:, some].T @ (products[:-1, -1] / size)
    return float((scores**2 / values[some]).sum()), int(some.sum())
