"""A hypothesis of the gap: iron, effects, and a rest with its own colour; one likelihood for all, on held-out folds."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from sim.state import Array
from validation.diagnosis.evidence.rest import Rest
from validation.diagnosis.evidence.rows import Rows


@dataclass(frozen=True, eq=False)
class Hypothesis:
    """``y = B beta + E c + rest`` on rows: the rest, beta (q, p), c (k,), and the log-likelihoods.

    held: of the rows that each fold holds out, with beta and c of the others. whole: of all rows.
    """

    rest: Rest
    beta: Array
    c: Array
    held: float
    whole: float

    @classmethod
    def given(cls, rows: Rows, columns: Array, rest: Rest) -> Hypothesis:
        """The hypothesis with columns (n, q, k) and a rest that is known: generalised least squares."""
        stacked = np.concatenate([rows.base, columns, rows.target[:, :, None]], axis=2)
        z, ln_S = rest.whitened(rows.row_s, rows.count, stacked)
        folds = [rows.fold == fold for fold in range(rows.policy.folds)]
        products = np.stack([np.einsum("nqi,nqj->qij", z[use], z[use], optimize=True) for use in folds])
        constant = np.array([ln_S[use].sum() for use in folds])
        p, total = rows.base.shape[2], products.sum(axis=0)
        held = [_half(one, constant[i], _solved(total - one, p)) for i, one in enumerate(products)]
        solution = _solved(total, p)
        beta, c = solution[:, :p], solution[0, p:-1]
        return cls(rest, beta, c, sum(held), _half(total, constant.sum(), solution))

    @classmethod
    def of(cls, rows: Rows, columns: Array, starts: tuple[Rest, ...]) -> Hypothesis:
        """The hypothesis with a rest of its own, from the residual of each start the likelier one.

        From one start alone a linear drift is swallowed by a slow rest.
        """
        found = []
        for start in starts:
            first = cls.given(rows, columns, start)
            rest = Rest.of(first.residual(rows, columns), rows.interval_s, rows.policy)
            found.append(cls.given(rows, columns, rest))
        return max(found, key=lambda one: one.whole)

    def residual(self, rows: Rows, columns: Array) -> Array:
        """What base and effects leave (n, q)."""
        left = rows.target - np.einsum("nqp,qp->nq", rows.base, self.beta)
        return np.asarray(left - np.einsum("nqk,k->nq", columns, self.c))


def _solved(products: Array, p: int) -> Array:
    """``(beta_a, c, -1)`` (q, p + k + 1) of least squares from products (q, p + k + 1, p + k + 1): c is shared."""
    BB, BE, By = products[:, :p, :p], products[:, :p, p:-1], products[:, :p, -1]
    EE, Ey = products[:, p:-1, p:-1].sum(axis=0), products[:, p:-1, -1].sum(axis=0)
    inverse = np.linalg.pinv(BB, rcond=1e-13, hermitian=True)
    S = EE - np.einsum("qpi,qpr,qrj->ij", BE, inverse, BE, optimize=True)
    size = np.sqrt(np.maximum(np.diag(EE), 1e-300))
    inner = np.linalg.pinv(S / np.outer(size, size), rcond=1e-9, hermitian=True) / np.outer(size, size)
    c = inner @ (Ey - np.einsum("qpi,qpr,qr->i", BE, inverse, By, optimize=True))
    beta = np.einsum("qpr,qr->qp", inverse, By - BE @ c)
    return np.concatenate([beta, np.tile(np.append(c, -1.0), (len(beta), 1))], axis=1)


def _half(products: Array, ln_S: float, solution: Array) -> float:
    """Log-likelihood without its constant: minus half of ln S and of the squares."""
    return -(ln_S + float(np.einsum("qi,qij,qj->", solution, products, solution))) / 2


def white(q: int) -> Rest:
    """A rest without slow processes."""
    return Rest(np.ones(1), np.ones(q), np.zeros((q, 1)))
