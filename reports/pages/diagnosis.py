"""Page of a diagnosis: missing effect, certainty, alternatives and advice, then the plots."""

from __future__ import annotations

from typing import Any

import numpy as np

from diagnosis.evidence.start_transients import find_start_samples
from diagnosis.repair.model_diff import model_diff
from diagnosis.result import Diagnosis, EvidenceKind, NamedEffect, Transfer
from diagnosis.verdict import Verdict
from reports.gap_series import displayed_gap, gap_along_path, has_path, hidden_by_iron_refit, rms_nT
from reports.pages.section import Section, drawn_sections
from reports.pages.template import render_page
from reports.plots import diagnosis as plots
from reports.plots.channel_curves import draw_curves
from reports.text.diagnosis import (
    CANDIDATE_HEADS,
    PART_HEADS,
    candidate_rows,
    gap_rows,
    parameter_rows,
    part_rows,
)
from scenarios.toml import to_toml
from validation.text import digits

FITTED = (EvidenceKind.HELD_OUT, EvidenceKind.IRON)
"""Ways of finding a cause with evidence in nats of a fit."""
SECTIONS = (
    Section("Gap over time",
            "Measured minus simulated, by body axis or as field strength. After (blue): noise about zero if the new "
            "model is complete.", plots.draw_gap),
    Section("Curves of channels",
            "Fitted curve with 95 % band; dots: the gap without the curve. A curve identifies the channel that the gap "
            "follows, not the mechanism.", draw_curves,
            lambda found: any(one.kind is EvidenceKind.CURVE for one in found.named)),
    Section("Gap along the path", "Means over a second or longer; before and after have the same colour scale.",
            plots.draw_map, lambda found: has_path(gap_along_path(found))),
    Section("Gap by channel",
            "The gap against the channels with the largest correlation; bold: means over bins. A correlation is a "
            "clue, not a proof.", plots.draw_channel),
    Section("Gap by frequency", "White noise lies on the dashed line.", plots.draw_spectrum),
    Section("Evidence of each candidate",
            "Each effect alone, fitted with hard and soft iron and its own noise model. Blue: accepted; red: cannot be "
            "distinguished from the accepted effect; tick: evidence needed.",
            plots.draw_ranking, lambda found: bool(found.ranking)),
)  # fmt: skip


def diagnosis_page(diagnosis: Diagnosis, title: str) -> str:
    """Return the page as self-contained HTML."""
    return render_page("diagnosis.html", _page(diagnosis, title))


def _page(diagnosis: Diagnosis, title: str) -> dict[str, Any]:
    return {
        "title": title,
        "verdict": diagnosis.verdict,
        "meaning": diagnosis.verdict.meaning,
        "sentence": diagnosis.sentence,
        "tiles": _tiles(diagnosis),
        "effects": [_row(one) for one in diagnosis.named],
        "classes": [(one.name, one.look_alikes) for one in diagnosis.named if one.look_alikes],
        "gaps": gap_rows(diagnosis),
        "candidate_heads": CANDIDATE_HEADS,
        "part_heads": PART_HEADS,
        "candidates": candidate_rows(diagnosis),
        "left": "; ".join((*diagnosis.unexplained, *diagnosis.doubts)),
        "advice": diagnosis.advice,
        "not_observable": diagnosis.not_observable,
        "where": diagnosis.where,
        "parts": part_rows(diagnosis),
        "diff": model_diff(diagnosis),
        "model": to_toml(diagnosis.model),
        "sections": drawn_sections(SECTIONS, diagnosis),
    }


def _tiles(diagnosis: Diagnosis) -> list[tuple[str, str]]:
    """Return the answer in four tiles (value, label)."""
    missing = ", ".join(one.name for one in diagnosis.named) or (
        "nothing" if diagnosis.verdict is Verdict.NONE else "not identified"
    )
    return [(missing, "missing in the model"), _sure(diagnosis), _otherwise(diagnosis), _share(diagnosis)]


def _otherwise(diagnosis: Diagnosis) -> tuple[str, str]:
    """Return the alternatives to the cause, or without a cause the channels that the gap follows."""
    if not diagnosis.named:
        return (", ".join(name for name, _, _ in diagnosis.where[:3]) or "–", "the gap follows")
    others = [name for one in diagnosis.named for name in one.look_alikes]
    if diagnosis.verdict is Verdict.NOT_OBSERVABLE:
        others += diagnosis.absorbed
    return (", ".join(dict.fromkeys(others)) or "no tested alternative", "could also be")


def _share(diagnosis: Diagnosis) -> tuple[str, str]:
    gap = diagnosis.gap
    if hidden_by_iron_refit(diagnosis):
        before, after = (digits(rms_nT(diagnosis, side)) for side in displayed_gap(diagnosis))
        return (
            f"{before} → {after} nT",
            "measured minus simulated, models without refit; a refit of the iron would hide the gap",
        )
    if _all_left_out(diagnosis):
        return ("–", "affected samples are left out of the comparison; the new model reproduces the values")
    if diagnosis.named and all(one.effect.stochastic for one in diagnosis.named):
        return (
            "its size",
            "noise cannot be predicted sample by sample: the gap remains; the new model has noise of equal size",
        )
    if gap.explained is None:
        return ("–", "no gap beyond the noise with iron refitted")
    before, after = (digits(size) for size in gap.structure_nT)
    removed = f"{100 * max(gap.explained, 0):.0f} % removed on held-out data"
    return (f"{before} → {after} nT", f"structure beyond {digits(gap.noise_nT)} nT of noise; {removed}")


def _all_left_out(diagnosis: Diagnosis) -> bool:
    """Return whether every cause was found in the values themselves and made some samples unusable."""
    wrong = (diagnosis.problem.usable == 0) & ~find_start_samples(diagnosis.problem)
    return bool(wrong.any()) and all(one.kind is EvidenceKind.DIRECT for one in diagnosis.named)


def _sure(diagnosis: Diagnosis) -> tuple[str, str]:
    """Return the evidence of the least certain cause."""
    if not diagnosis.named:
        return ("–", "no cause identified")
    one = min(diagnosis.named, key=lambda one: np.inf if one.nats is None else one.nats)
    whose = f" for {one.name}, the least certain" if len(diagnosis.named) > 1 else ""
    again = _again(diagnosis, one)
    if one.nats is None or one.kind not in FITTED:
        return (one.kind.words, f"evidence{whose}; {again}")
    needed = f"; {digits(one.needed)} are needed" if one.needed else ""
    return (f"{digits(one.nats)} nats", f"evidence on held-out data{whose}{needed}; {again}")


def _again(diagnosis: Diagnosis, one: NamedEffect) -> str:
    """Return whether a second recording confirms the cause."""
    if one.transfer is Transfer.TRANSFERRED:
        return "confirmed by a second recording"
    if not diagnosis.has_second:
        return "one recording; confirm with a second"
    return (
        "the second recording does not confirm it" if one.transferable else "one recording; a second cannot confirm it"
    )


def _row(one: NamedEffect) -> dict[str, Any]:
    lines = [
        f"{name} = {value} {unit}" if low is None else f"{name} = {value} [{low} to {high}] {unit}"
        for name, value, low, high, unit in parameter_rows(one)
    ]
    strength = f"{one.strength:.2g} sigma, {one.nats:.3g} nats" if one.kind in FITTED and one.nats else ""
    return {"name": one.name, "alternatives": one.look_alikes, "lines": lines, "how": one.kind.words,
            "evidence": ", ".join(filter(None, (strength, one.transfer)))}  # fmt: skip
