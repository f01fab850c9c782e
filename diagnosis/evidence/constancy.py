"""One size all along: an effect keeps its coefficients from part to part of a run, what resembles it does not."""

from __future__ import annotations

import numpy as np
from scipy.stats import chi2

from diagnosis.evidence.candidate_test import CandidateFit, ColouredBaseline
from diagnosis.evidence.hypothesis import information_by_part
from scenarios.arrays import Array

OPEN = 1e-6
"""Eigenvalue of a part's information, its columns scaled to one, below which it says nothing of a combination."""


def differs_along_the_run(one: CandidateFit, beside: ColouredBaseline, share: float) -> bool:
    """Whether the parts of a run ask for coefficients of their own, beyond their errors and an error of form.

    ``Q = sum_b g_b^T N_b^-1 g_b - g^T N^-1 g`` of the parts' information N_b (k, k) and scores g_b (k,), and of their
    sums: chi-square with the combinations that the parts determine less those of the whole. What a part does not show
    says nothing there. share: part of what the effect explains that an error of form may make of Q.
    """
    policy = beside.rows.policy
    parts = information_by_part(one.rows, beside.inside, one.columns, one.hypothesis.rest, policy.scatter_parts)
    (whole, known), each = _explained(np.sum(parts, axis=0)), [_explained(part) for part in parts]
    degrees = sum(rank for _, rank in each) - known
    Q = sum(squares for squares, _ in each) - whole
    by_chance = degrees == 0 or chi2.sf(Q, degrees) > policy.alpha
    return not by_chance and bool(Q - degrees > share * whole)


def _explained(products: Array) -> tuple[float, int]:
    """Squares that k columns explain, from products (k + 1, k + 1) of them and the target, and their rank."""
    size = np.sqrt(np.maximum(np.diag(products)[:-1], 1e-300))
    values, vectors = np.linalg.eigh(products[:-1, :-1] / np.outer(size, size))
    some = values > OPEN
    scores = vectors[:, some].T @ (products[:-1, -1] / size)
    return float((scores**2 / values[some]).sum()), int(some.sum())
