"""Presentation of the diagnosis of a single recording."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Self

import numpy as np

from diagnosis.evidence.direct import find_start_samples
from diagnosis.evidence.held_out import CandidateResult
from diagnosis.repair.new_model import lines_of_diff, written_model
from diagnosis.result import Diagnosis, EvidenceKind, NamedEffect, Transfer, parameters
from diagnosis.verdict import Verdict
from reports.presentation.answer import PresentedAnswer, gap_cells, noise_tile
from reports.presentation.channel_curves import ChannelCurve, channel_curves
from reports.presentation.series import DiagnosisSeries
from scenarios.toml import to_toml
from sim.effects.parameters import ACTIVE_WINDOW
from validation.text import digits, figure, short

FITTED = (EvidenceKind.HELD_OUT, EvidenceKind.IRON)
"""Ways of finding a cause with evidence in nats of a fit."""
GAP_HEADS = ("gap, rms", "before, nT", "after, nT", "before / noise", "after / noise", "explained")
PARAMETER_HEADS = ("parameter", "value", "low", "high", "unit")
PART_HEADS = ("from, s", "to, s", "phase", "heading", "gap, nT rms", "over the noise")
CANDIDATE_HEADS = ("candidate", "evidence, nats", "needed, nats", "alone, nT", "outcome")
NO_CELLS = ("–",) * 3
"""Cells of GAP_HEADS that a row has no figures for."""
Row = tuple[str, ...]
ParameterRow = tuple[str, str, str | None, str | None, str]
"""Name, value, ends of the 95 % interval (None: unknown) and unit of a parameter in use."""


@dataclass(frozen=True)
class PresentedCause:
    """A missing effect: other effects that explain the gap as well, parameters, and evidence.

    alternatives: other effects. look_alikes: also effects of other channels. how: kind of evidence in words.
    """

    name: str
    alternatives: tuple[str, ...]
    look_alikes: tuple[str, ...]
    parameters: tuple[ParameterRow, ...]
    how: str
    evidence: str

    @classmethod
    def of(cls, cause: NamedEffect) -> Self:
        """Describe a named effect."""
        size = (
            f"{figure(cause.strength, 2)} times the noise, {figure(cause.nats)} nats"
            if cause.kind in FITTED and cause.nats
            else ""
        )
        evidence = ", ".join(filter(None, (size, cause.transfer)))
        rows = tuple(parameter_rows(cause))
        return cls(cause.name, cause.alternatives, cause.look_alikes, rows, cause.kind.words, evidence)


@dataclass(frozen=True, kw_only=True)
class PresentedDiagnosis(PresentedAnswer):
    """What page, viewer, terminal and notebook show of a diagnosis.

    gaps: `GAP_HEADS`. parts: `PART_HEADS`, empty for a run with a steady size of the gap. candidates:
    `CANDIDATE_HEADS`, the strongest first. ranking: results behind the candidates' rows. left: structure not explained,
    in words. curves: of channels. next_flight: scenario of the advised flight as TOML.
    """

    causes: tuple[PresentedCause, ...]
    parts: tuple[Row, ...]
    candidates: tuple[Row, ...]
    ranking: tuple[CandidateResult, ...]
    left: str
    curves: tuple[ChannelCurve, ...]
    series: DiagnosisSeries
    next_flight: str | None

    @classmethod
    def of(cls, diagnosis: Diagnosis) -> Self:
        """Compute all rows and series of a diagnosis."""
        series = DiagnosisSeries.of(diagnosis)
        flight = diagnosis.next_flight
        return cls(
            verdict=diagnosis.verdict,
            sentence=diagnosis.sentence,
            advice=diagnosis.advice,
            tiles=tuple(_tiles(diagnosis, series)),
            gaps=tuple(_gap_rows(diagnosis, series)),
            where=diagnosis.where,
            not_observable=diagnosis.not_observable,
            diff=lines_of_diff(diagnosis.given, diagnosis.model),
            model=written_model(diagnosis.model),
            summary=diagnosis.as_dict(),
            date=str(diagnosis.problem.recording.origin.date or ""),
            causes=tuple(map(PresentedCause.of, diagnosis.named)),
            parts=tuple(_part_rows(diagnosis)),
            candidates=tuple(_candidate_rows(diagnosis)),
            ranking=diagnosis.ranking,
            left="; ".join((*diagnosis.unexplained, *diagnosis.doubts)),
            curves=channel_curves(diagnosis),
            series=series,
            next_flight=None if flight is None else to_toml(flight.scenario),
        )


def parameter_rows(cause: NamedEffect) -> Iterator[ParameterRow]:
    """Yield the parameters in use; without an interval only if not zero."""
    for name, p in parameters(cause).items():
        if p["low"] is not None:
            yield name, short(p["value"]), short(p["low"]), short(p["high"]), p["unit"]
        elif isinstance(p["value"], str) or np.any(p["value"]):
            yield name, short(p["value"]), None, None, p["unit"]
    if cause.effect.active_s is not None:
        yield ACTIVE_WINDOW.name, short(list(cause.effect.active_s)), None, None, ACTIVE_WINDOW.unit


def cells(row: ParameterRow) -> Row:
    """Return the cells of a table; empty where the interval is unknown."""
    return tuple(cell or "" for cell in row)


def _part_rows(diagnosis: Diagnosis) -> Iterator[Row]:
    for part in diagnosis.parts if len(diagnosis.parts) > 1 else ():
        heading = "–" if part.heading_deg is None else f"{part.heading_deg:.0f}°"
        sizes = (digits(part.rms_nT), digits(part.rms_sigma))
        yield digits(part.from_s), digits(part.to_s), part.phase or "–", heading, *sizes


def _candidate_rows(diagnosis: Diagnosis) -> Iterator[Row]:
    """Yield every tested candidate; alone: rms with iron refitted."""
    for one in diagnosis.ranking:
        alone_nT = one.evidence.strength * diagnosis.gap.noise_nT
        yield one.name, digits(one.nats), digits(one.needed), digits(alone_nT), one.outcome


def _gap_rows(diagnosis: Diagnosis, series: DiagnosisSeries) -> Iterator[Row]:
    gap = diagnosis.gap
    yield "held-out segments, iron refitted", *gap_cells(gap)
    if gap.explained is not None:
        yield f"structure beyond {digits(gap.noise_nT)} nT of noise", *map(digits, gap.structure_nT), *NO_CELLS
    if series.vector:
        yield "whole recording, models without refit", *map(digits, series.difference.rms_nT()), *NO_CELLS


def _tiles(diagnosis: Diagnosis, series: DiagnosisSeries) -> Iterator[tuple[str, str]]:
    """Yield what is missing, its evidence, what else it may be, and how much of the gap it explains."""
    yield _missing(diagnosis)
    if diagnosis.named:
        yield _sure(diagnosis)
    if diagnosis.named or diagnosis.where:
        yield _otherwise(diagnosis)
    yield _share(diagnosis, series)


def _missing(diagnosis: Diagnosis) -> tuple[str, str]:
    nothing = "nothing" if diagnosis.verdict is Verdict.NONE else "not identified"
    return ", ".join(cause.name for cause in diagnosis.named) or nothing, "missing in the model"


def _otherwise(diagnosis: Diagnosis) -> tuple[str, str]:
    """Return the alternatives to the cause, or without a cause the channels that the gap follows."""
    if not diagnosis.named:
        return ", ".join(name for name, _, _ in diagnosis.where[:3]), "the gap follows"
    others = [name for cause in diagnosis.named for name in cause.look_alikes]
    if diagnosis.verdict is Verdict.NOT_OBSERVABLE:
        others += diagnosis.absorbed
    return ", ".join(dict.fromkeys(others)) or "no tested alternative", "could also be"


def _share(diagnosis: Diagnosis, series: DiagnosisSeries) -> tuple[str, str]:
    gap = diagnosis.gap
    if series.hidden:
        before, after = map(digits, series.difference.rms_nT())
        hides = "measured minus simulated, models without refit; a refit of the iron would hide the gap"
        return f"{before} → {after} nT", hides
    if _all_left_out(diagnosis):
        return "left out", "affected samples are left out of the comparison; the new model reproduces the values"
    if diagnosis.named and all(cause.effect.stochastic for cause in diagnosis.named):
        remains = "noise cannot be predicted sample by sample: the gap remains; the new model has noise of equal size"
        return "its size", remains
    if gap.explained is None:
        return noise_tile(gap)
    before, after = map(digits, gap.structure_nT)
    removed = f"{100 * max(gap.explained, 0):.0f} % removed on held-out data"
    return f"{before} → {after} nT", f"structure beyond {digits(gap.noise_nT)} nT of noise; {removed}"


def _all_left_out(diagnosis: Diagnosis) -> bool:
    """Return whether every cause was found in the values themselves and made some samples unusable."""
    wrong = (diagnosis.problem.usable == 0) & ~find_start_samples(diagnosis.problem)
    return bool(wrong.any()) and all(cause.kind is EvidenceKind.DIRECT for cause in diagnosis.named)


def _sure(diagnosis: Diagnosis) -> tuple[str, str]:
    """Return the evidence of the least certain cause."""
    least = min(diagnosis.named, key=lambda cause: np.inf if cause.nats is None else cause.nats)
    whose = f" for {least.name}, the least certain" if len(diagnosis.named) > 1 else ""
    again = _again(diagnosis, least)
    if least.nats is None or least.kind not in FITTED:
        return least.kind.words, f"evidence{whose}; {again}"
    nats = f"{digits(least.nats)} nats"
    if not least.needed:
        return nats, f"evidence on held-out data{whose}; {again}"
    told = f"{nats} on held-out data{whose}, of {digits(least.needed)} needed; {again}"
    return f"{digits(least.nats / least.needed, 2)} times", f"the evidence needed: {told}"


def _again(diagnosis: Diagnosis, cause: NamedEffect) -> str:
    """Return whether a second recording confirms the cause."""
    if cause.transfer is Transfer.TRANSFERRED:
        return "confirmed by a second recording"
    if not diagnosis.has_second:
        return "one recording; confirm with a second"
    confirms = "the second recording does not confirm it", "one recording; a second cannot confirm it"
    return confirms[0] if cause.transferable else confirms[1]
