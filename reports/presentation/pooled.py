"""Presentation of a pooled diagnosis: of several recordings, or of the sensors of an array."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any, Self

import numpy as np

from diagnosis.repair.new_model import lines_of_diff, written_model
from diagnosis.result import NamedEffect, Transfer, parameters
from diagnosis.several.common_effects import CommonEffect
from diagnosis.several.pooled_effect import Presence
from diagnosis.several.result import PooledDiagnosis, Scope
from diagnosis.several.sentence import describe_transfer
from reports.presentation.answer import PresentedAnswer, gap_cells, noise_tile
from reports.presentation.diagnosis import PresentedDiagnosis, Row, cells, parameter_rows
from reports.presentation.series import GapSeries
from validation.text import all_of, digits, symbol

POOLED = "pooled"
"""First cell of the rows of the pooled coefficient."""
Interval = tuple[float, float, float]
"""Value and ends of the 95 % interval; without an interval, the value three times."""


@dataclass(frozen=True)
class CoefficientPanel:
    """A component of a parameter: its pooled value, and its value in each recording (None: unknown)."""

    label: str
    pooled: Interval
    each: tuple[Interval | None, ...]


@dataclass(frozen=True)
class PresentedEffect:
    """An effect common to recordings: reach, agreement, coefficient rows and panels by recording.

    rows: recording, finding, parameter, value, low, high, unit; the pooled value first. test: of equal coefficients.
    """

    name: str
    reach: str
    transferred: bool
    words: str
    look_alikes: tuple[str, ...]
    test: str
    how: str
    nats: str
    rows: tuple[Row, ...]
    panels: tuple[CoefficientPanel, ...]
    presence: tuple[Presence, ...]

    @classmethod
    def of(cls, effect: CommonEffect, pooled: PooledDiagnosis) -> Self:
        """Describe a common effect."""
        named = effect.named
        return cls(
            name=effect.name,
            reach=pooled.scope.labels[effect.transfer],
            transferred=effect.transfer is Transfer.TRANSFERRED,
            words=describe_transfer(effect, pooled.scope),
            look_alikes=named.look_alikes,
            test=_agreement(effect),
            how=named.kind.words,
            nats="" if named.nats is None else f"{digits(named.nats)} nats",
            rows=tuple(_coefficient_rows(pooled, effect)),
            panels=tuple(_panels(effect)),
            presence=effect.presence,
        )


@dataclass(frozen=True, kw_only=True)
class PresentedPool(PresentedAnswer):
    """What page, viewer, terminal and notebook show of a pooled diagnosis of n recordings.

    gaps: a row per recording and a row of all: rms before and after (nT, over noise), share explained, verdict. series:
    gap of each recording, with the coefficients predicted by the others.
    """

    names: tuple[str, ...]
    each: tuple[PresentedDiagnosis, ...]
    scope: Scope
    common: tuple[PresentedEffect, ...]
    single: tuple[PresentedEffect, ...]
    left: tuple[str, ...]
    series: tuple[GapSeries, ...]

    @classmethod
    def of(cls, pooled: PooledDiagnosis) -> Self:
        """Compute all rows and series of a pooled diagnosis."""
        each = tuple(map(PresentedDiagnosis.of, pooled.each))
        residuals = (own.series.residual for own in each)
        gaps = zip(residuals, pooled.gaps, strict=True)
        return cls(
            verdict=pooled.verdict,
            sentence=pooled.sentence,
            advice=pooled.advice,
            tiles=_tiles(pooled),
            gaps=tuple(_gap_rows(pooled)),
            where=pooled.where,
            not_observable=pooled.not_observable,
            diff=lines_of_diff(pooled.each[0].problem.effects, pooled.model),
            model=written_model(pooled.model),
            summary=pooled.as_dict(),
            names=pooled.names,
            each=each,
            scope=pooled.scope,
            common=tuple(PresentedEffect.of(effect, pooled) for effect in pooled.common),
            single=tuple(PresentedEffect.of(effect, pooled) for effect in pooled.single),
            left=pooled.unexplained,
            series=tuple(GapSeries(own.time_s, own.usable, gap.before_nT, gap.after_nT) for own, gap in gaps),
        )


def _coefficient_rows(pooled: PooledDiagnosis, effect: CommonEffect) -> Iterator[Row]:
    """Yield the rows of the pooled value, then of each recording; shared parameters only with the pooled value."""
    words = describe_transfer(effect, pooled.scope)
    yield from ((POOLED, words, *cells(row)) for row in parameter_rows(effect.named))
    for recording, finding, own in zip(pooled.names, effect.presence, effect.each, strict=True):
        fitted = [] if own is None else parameter_rows(own)
        rows = [row for row in fitted if effect.agreement is None or row[2] is not None]
        yield from ((recording, str(finding), *row) for row in map(cells, rows))
        if not rows:
            yield recording, str(finding), *("",) * 5


def _agreement(effect: CommonEffect) -> str:
    """Return the test of equal coefficients in words."""
    agree = effect.agreement
    if agree is None or not agree.degrees:
        return "sizes compared, no test"
    odds = "less than 0.001" if agree.p < 1e-3 else f"{agree.p:.2g}"
    test = f"chi-square {digits(agree.chi2)} of {agree.degrees}"
    return f"equal coefficients differ by chance this much or more with probability {odds} ({test})"


def _panels(effect: CommonEffect) -> Iterator[CoefficientPanel]:
    """Yield the components of the fitted parameters, or of all numbers where none was fitted."""
    known = parameters(effect.named)
    fitted = [name for name, p in known.items() if p["low"] is not None]
    for name in fitted or [name for name, p in known.items() if not isinstance(p["value"], str)]:
        pooled = _intervals(effect.named, name)
        each = [[None] * len(pooled) if own is None else _intervals(own, name) for own in effect.each]
        for part, *component in zip(_parts(name, len(pooled)), pooled, *each, strict=True):
            label = f"{name} {part} ({symbol(known[name]['unit'])})".replace(" ()", "")
            yield CoefficientPanel(label, component[0], tuple(component[1:]))


def _parts(name: str, size: int) -> tuple[str, ...]:
    axes = ("east", "north", "up") if "enu" in name else ("x", "y", "z")
    if size == 1:
        return ("",)
    return axes if size == 3 else tuple(a + b for a in "xyz" for b in "xyz")


def _intervals(cause: NamedEffect, name: str) -> list[Any]:
    p = parameters(cause)[name]
    ends = (p["value"] if p[end] is None else p[end] for end in ("low", "high"))
    return list(zip(*(np.ravel(values).tolist() for values in (p["value"], *ends)), strict=True))


def _gap_rows(pooled: PooledDiagnosis) -> Iterator[Row]:
    for name, gap, own in zip(pooled.names, pooled.gaps, pooled.each, strict=True):
        yield name, *gap_cells(gap.gap), str(own.verdict)
    yield "all", *gap_cells(pooled.gap), str(pooled.verdict)


def _tiles(pooled: PooledDiagnosis) -> tuple[tuple[str, str], ...]:
    """Return the answer in two to four tiles (value, label)."""
    by_reach = {transfer: [one.name for one in pooled.common if one.transfer is transfer] for transfer in Transfer}
    same = ", ".join(by_reach[Transfer.TRANSFERRED]) or "nothing"
    differs = ", ".join([*by_reach[Transfer.NOT_TRANSFERRED], *by_reach[Transfer.SOME]])
    alone = ", ".join(one.name for one in pooled.single)
    parts = ((differs, "missing, but not equal in all"), (alone, f"cause in one {pooled.scope.noun} only"))
    return (
        (same, f"missing in the model, equal in {all_of(len(pooled.names), pooled.scope.key)}"),
        *(one for one in parts if one[0]),
        _share(pooled),
    )


def _share(pooled: PooledDiagnosis) -> tuple[str, str]:
    if pooled.gap.explained is None:
        return noise_tile(pooled.gap)
    share = f"{100 * max(pooled.gap.explained, 0):.0f} %"
    return share, f"of the gap beyond the noise explained, {pooled.scope.after}"
