"""Sentences and table rows of a pooled diagnosis."""

from __future__ import annotations

from collections.abc import Iterator

from diagnosis.result import GapSize
from diagnosis.several.common_effects import CommonEffect
from diagnosis.several.result import PooledDiagnosis
from diagnosis.several.sentence import describe_transfer
from reports.text.diagnosis import parameter_rows
from validation.text import digits

POOLED = "pooled"
"""First cell of the rows of the pooled coefficient."""


def coefficient_rows(pooled: PooledDiagnosis, one: CommonEffect) -> Iterator[tuple[str, ...]]:
    """Yield recording, finding, parameter, value, low, high, unit; the pooled value first."""
    for row in parameter_rows(one.named):
        yield (POOLED, describe_transfer(one, pooled.scope), *_cells(row))
    for recording, finding, own in zip(pooled.names, one.presence, one.each, strict=True):
        rows = [] if own is None else [row for row in parameter_rows(own) if _is_own(row, one)]
        for cells in map(_cells, rows) if rows else [("",) * 5]:
            yield (recording, str(finding), *cells)


def _cells(row: tuple[str | None, ...]) -> tuple[str, ...]:
    return tuple(cell or "" for cell in row)


def _is_own(row: tuple[str | None, ...], one: CommonEffect) -> bool:
    """Return whether a parameter's row was fitted to the recording rather than shared by all."""
    return one.p is None or row[2] is not None


def agreement_line(one: CommonEffect) -> str:
    """Return the test of equal coefficients in words."""
    if one.p is None or one.chi2 is None or not one.degrees:
        return "sizes compared, no test"
    odds = "less than 0.001" if one.p < 1e-3 else f"{one.p:.2g}"
    test = f"chi-square {digits(one.chi2)} of {one.degrees}"
    return f"equal coefficients differ by chance this much or more with probability {odds} ({test})"


def pooled_gap_rows(pooled: PooledDiagnosis) -> list[tuple[str, ...]]:
    """Return a row per recording and a row of all: rms before and after (nT, over noise), share explained, verdict."""
    rows = [
        (name, *_gap_cells(gap), str(own.verdict))
        for name, gap, own in zip(pooled.names, pooled.gaps, pooled.each, strict=True)
    ]
    return [*rows, ("all", *_gap_cells(pooled.gap), str(pooled.verdict))]


def _gap_cells(gap: GapSize) -> tuple[str, ...]:
    sizes = (digits(v) for v in (gap.before_nT, gap.after_nT, gap.before_sigma, gap.after_sigma))
    return (*sizes, "no gap" if gap.explained is None else f"{100 * gap.explained:.1f} %")
