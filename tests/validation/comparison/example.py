"""Tables of comparisons made by hand: what the trials gave is known."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np
import pyarrow as pa

from validation.comparison.trial_table import TrialTable

SCORE = "offset_error_nT"


def table_of(
    *points: Mapping[str, Sequence[float]], sweep: Sequence[float] = (), failing: Sequence[str] = ()
) -> TrialTable:
    """A table of a score by calibrator at each point, n trials each; a score of inf: no estimate, not converged.

    sweep : the noise of each point; failing : calibrators whose status is never ok, though they give an estimate.
    """
    rows = []
    for point, scores in enumerate(points):
        n = len(next(iter(scores.values())))
        for run in range(n):
            for name, values in scores.items():
                value = values[run]
                status, reason = _judged(value, name in failing)
                rows.append((point, run, 0, name, status, reason, float(value) if np.isfinite(value) else None))
    names = ("point", "run", "seed", "calibrator", "status", "reason", SCORE)
    columns = dict(zip(names, map(list, zip(*rows, strict=True)), strict=True))
    if sweep:
        columns["effects.white_noise.std_nT"] = [sweep[point] for point in columns["point"]]
    return TrialTable(pa.table(columns), {})


def _judged(value: float, failing: bool) -> tuple[str, str]:
    if not np.isfinite(value):
        return "not_converged", "it broke down"
    return ("unobservable", "flat motion") if failing else ("ok", "")
