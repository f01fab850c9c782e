"""Sentences and table rows of a diagnosis."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from diagnosis.result import Diagnosis, NamedEffect, parameters
from diagnosis.several.result import PooledDiagnosis
from reports.gap_series import compared_series, rms_nT
from sim.effects.parameters import ACTIVE_WINDOW
from validation.text import digits, short


def headline(diagnosis: Diagnosis | PooledDiagnosis) -> str:
    """Return verdict, sentence and advice."""
    lines = [f"verdict: {diagnosis.verdict} ({diagnosis.verdict.meaning})", diagnosis.sentence]
    if diagnosis.advice:
        lines += ["", "what to do next", *(f"{i}. {line}" for i, line in enumerate(diagnosis.advice, start=1))]
    return "\n".join(lines)


def parameter_rows(one: NamedEffect) -> Iterator[tuple[str, str, str | None, str | None, str]]:
    """Yield name, value, ends of the 95 % interval (None: unknown) and unit of the parameters in use."""
    for name, p in parameters(one).items():
        if p["low"] is not None:
            yield name, short(p["value"]), short(p["low"]), short(p["high"]), p["unit"]
        elif isinstance(p["value"], str) or np.any(p["value"]):
            yield name, short(p["value"]), None, None, p["unit"]
    if one.effect.active_s is not None:
        yield ACTIVE_WINDOW.name, short(list(one.effect.active_s)), None, None, ACTIVE_WINDOW.unit


PART_HEADS = ("from, s", "to, s", "phase", "heading", "gap, nT rms", "over the noise")


def part_rows(diagnosis: Diagnosis) -> list[tuple[str, ...]]:
    """Return the parts of the run with steady size of the gap, by time: `PART_HEADS`; empty for a single part."""
    if len(diagnosis.parts) < 2:
        return []
    rows = [(one.stretch, one.rms_nT, one.rms_sigma) for one in diagnosis.parts]
    return [
        (
            digits(when.from_s),
            digits(when.to_s),
            when.phase or "–",
            "–" if when.heading_deg is None else f"{when.heading_deg:.0f}°",
            digits(size_nT),
            digits(size_sigma),
        )
        for when, size_nT, size_sigma in rows
    ]


CANDIDATE_HEADS = ("candidate", "evidence, nats", "needed, nats", "alone, nT", "outcome")


def candidate_rows(diagnosis: Diagnosis) -> list[tuple[str, ...]]:
    """Return every tested candidate, the strongest first: `CANDIDATE_HEADS`; alone: rms with iron refitted."""
    noise = diagnosis.gap.noise_nT
    return [
        (one.name, digits(one.nats), digits(one.needed), digits(one.evidence.strength * noise), one.outcome)
        for one in diagnosis.ranking
    ]


def gap_rows(diagnosis: Diagnosis) -> list[tuple[str, ...]]:
    """Return the gap as rows: description, rms before and after in nT and in units of the noise, share explained."""
    gap = diagnosis.gap
    share = "no gap" if gap.explained is None else f"{100 * gap.explained:.1f} %"
    sizes = [digits(v) for v in (gap.before_nT, gap.after_nT, gap.before_sigma, gap.after_sigma)]
    rows: list[tuple[str, ...]] = [("held-out segments, iron refitted", *sizes, share)]
    if gap.explained is not None:
        beyond = [digits(v) for v in gap.structure_nT]
        rows.append((f"structure beyond {digits(gap.noise_nT)} nT of noise", *beyond, "", "", ""))
    if diagnosis.problem.mode == "vector":
        both = compared_series(diagnosis)
        sizes = [digits(rms_nT(diagnosis, both.measured_nT - side)) for side in (both.before_nT, both.after_nT)]
        rows.append(("whole recording, models without refit", *sizes, "", "", ""))
    return rows
