"""Several recordings together in words and rows: what the report and the terminal share."""

from __future__ import annotations

from collections.abc import Iterator

from diagnosis.result import GapSize
from diagnosis.several.common_effects import Common
from diagnosis.several.result import PooledDiagnosis
from diagnosis.several.sentence import reach_of
from reports.text.diagnosis import parameter_rows
from validation.text import digits

POOLED = "together"
"""What the pooled coefficient stands under."""


def headline(found: PooledDiagnosis) -> str:
    """Verdict, sentence and what to do next."""
    lines = [f"verdict: {found.verdict} ({found.verdict.meaning})", found.sentence]
    if found.advice:
        lines += ["", "what to do next", *(f"{i}. {line}" for i, line in enumerate(found.advice, start=1))]
    return "\n".join(lines)


def coefficient_rows(found: PooledDiagnosis, one: Common) -> Iterator[tuple[str, ...]]:
    """Recording, what it says, parameter, value, low, high, unit; the pooled value first."""
    for row in parameter_rows(one.named):
        yield (POOLED, reach_of(one, found.among), *_cells(row))
    for recording, says, mine in zip(found.names, one.there, one.each, strict=True):
        rows = [] if mine is None else [row for row in parameter_rows(mine) if _is_own(row, one)]
        for cells in map(_cells, rows) if rows else [("",) * 5]:
            yield (recording, str(says), *cells)


def _cells(row: tuple[str | None, ...]) -> tuple[str, ...]:
    return tuple(cell or "" for cell in row)


def _is_own(row: tuple[str | None, ...], one: Common) -> bool:
    """Whether a row of one recording is no setting that all of them share."""
    return one.p is None or row[2] is not None


def agreement_line(one: Common) -> str:
    """The test of agreement in words."""
    if one.p is None or one.chi2 is None or not one.degrees:
        return "sizes compared, no test"
    odds = "less than 0.001" if one.p < 1e-3 else f"{one.p:.2g}"
    test = f"chi-square {digits(one.chi2)} of {one.degrees}"
    return f"equal coefficients differ as much by chance with probability {odds} ({test})"


def pooled_gap_rows(found: PooledDiagnosis) -> list[tuple[str, ...]]:
    """A row a recording and one of all: rms before and after in nT, in units of the noise, share explained, verdict."""
    rows = [
        (name, *_gap_cells(gap), str(own.verdict))
        for name, gap, own in zip(found.names, found.gaps, found.each, strict=True)
    ]
    return [*rows, ("all", *_gap_cells(found.gap), str(found.verdict))]


def _gap_cells(gap: GapSize) -> tuple[str, ...]:
    sizes = (digits(v) for v in (gap.before_nT, gap.after_nT, gap.before_sigma, gap.after_sigma))
    return (*sizes, "no gap" if gap.explained is None else f"{100 * gap.explained:.1f} %")
