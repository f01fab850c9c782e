"""The page of a diagnosis: what is missing, how sure, what else it could be, what to do; then the pictures."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from typing import Any

import numpy as np

from diagnosis.evidence.start_transients import unknown_past
from diagnosis.repair.model_diff import model_diff
from diagnosis.result import Diagnosis, How, Named, Transfer
from diagnosis.verdict import Verdict
from reports.gap_series import displayed_gap, gap_along_path, has_path, hidden_by_iron_refit, rms_nT
from reports.pages.section import figure_html
from reports.pages.template import render_page
from reports.plots import diagnosis as plots
from reports.plots.channel_curves import draw_curves
from reports.plots.style import Figure
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

Draw = Callable[[Diagnosis], Figure]
FITTED = (How.HELD_OUT, How.IRON)
"""Names whose evidence is counted in nats of a fit."""
GAP = (
    "The gap over time",
    "Body axes, or the field's strength. After (blue) should be noise about zero.",
    plots.draw_gap,
)
MAP = (
    "The gap along the path",
    "Means over a second or longer; one colour scale for before and after.",
    plots.draw_map,
)
CURVES = (
    "Curves of channels",
    "With the 95 % band; dots are what all else leaves. A curve names what the gap goes with, and no mechanism.",
    draw_curves,
)
REST: tuple[tuple[str, str, Draw], ...] = (
    ("The gap by channel", "Against the channels it goes with most, bold the means over bins: a clue, not a proof.",
     plots.draw_channel),
    ("The gap by frequency", "A clean rest lies on the dashed line.", plots.draw_spectrum),
    ("What each candidate explains",
     "Each effect alone, beside hard and soft iron fitted anew and the rest it was judged by. Blue: named; red: not "
     "told from it; a tick: the evidence needed.",
     plots.draw_ranking),
)  # fmt: skip


def diagnosis_page(found: Diagnosis, title: str) -> str:
    """The report as one HTML text that needs nothing else."""
    return render_page("diagnosis.html", _page(found, title))


def _page(found: Diagnosis, title: str) -> dict[str, Any]:
    curves = [CURVES] if any(one.how is How.CURVE for one in found.named) else []
    shown = [GAP, *curves, *([MAP] if has_path(gap_along_path(found)) else []), *(REST if found.ranking else REST[:2])]
    return {
        "title": title,
        "verdict": found.verdict,
        "meaning": found.verdict.meaning,
        "sentence": found.sentence,
        "tiles": _tiles(found),
        "effects": [_row(one) for one in found.named],
        "classes": [(one.name, one.others) for one in found.named if one.others],
        "gaps": gap_rows(found),
        "candidate_heads": CANDIDATE_HEADS,
        "part_heads": PART_HEADS,
        "candidates": candidate_rows(found),
        "left": "; ".join((*found.left, *found.doubts)),
        "advice": found.advice,
        "not_observable": found.not_observable,
        "where": found.where,
        "parts": part_rows(found),
        "diff": model_diff(found),
        "model": to_toml(found.model),
        "pictures": [(name, caption, figure_html(partial(draw, found), name)) for name, caption, draw in shown],
    }


def _tiles(found: Diagnosis) -> list[tuple[str, str]]:
    """The answer in four tiles: (value, label)."""
    missing = ", ".join(one.name for one in found.named) or (
        "nothing" if found.verdict is Verdict.NONE else "not named"
    )
    return [(missing, "missing in the model"), _sure(found), _otherwise(found), _share(found)]


def _otherwise(found: Diagnosis) -> tuple[str, str]:
    """What else it could be, or where nothing is named what the gap goes with."""
    if not found.named:
        return (", ".join(name for name, _, _ in found.where[:3]) or "–", "the gap goes with")
    others = [name for one in found.named for name in one.others]
    if found.verdict is Verdict.NOT_OBSERVABLE:
        others += found.absorbed
    return (", ".join(dict.fromkeys(others)) or "no other that was tested", "could also be")


def _share(found: Diagnosis) -> tuple[str, str]:
    gap = found.gap
    if hidden_by_iron_refit(found):
        before, after = (digits(rms_nT(found, side)) for side in displayed_gap(found))
        return (
            f"{before} → {after} nT",
            "measured minus simulated, the models as they stand; iron fitted anew hides it",
        )
    if _all_left_out(found):
        return ("–", "such values are left out of the comparison; the new model makes them")
    if found.named and all(one.effect.stochastic for one in found.named):
        return ("its amount", "noise cannot be foretold sample by sample: the gap stays, the new model has its size")
    if gap.explained is None:
        return ("–", "no gap beyond the noise once iron is fitted anew")
    before, after = (digits(size) for size in gap.structure_nT)
    how = f"structure in {digits(gap.noise_nT)} nT of noise, {100 * max(gap.explained, 0):.0f} % of it gone, held out"
    return (f"{before} → {after} nT", how)


def _all_left_out(found: Diagnosis) -> bool:
    """Whether all that is named shows in the values themselves, and made some of them no measurements."""
    wrong = (found.problem.usable == 0) & ~unknown_past(found.problem)
    return bool(wrong.any()) and all(one.how is How.DIRECT for one in found.named)


def _sure(found: Diagnosis) -> tuple[str, str]:
    """The evidence of the effect that is least sure."""
    if not found.named:
        return ("–", "no name to be sure of")
    one = min(found.named, key=lambda one: np.inf if one.nats is None else one.nats)
    whose = f" for {one.name}, the least sure" if len(found.named) > 1 else ""
    again = _again(found, one)
    if one.nats is None or one.how not in FITTED:
        return (one.how.words, f"is the evidence{whose}; {again}")
    needed = f"; {digits(one.needed)} are needed" if one.needed else ""
    return (f"{digits(one.nats)} nats", f"of evidence on held-out data{whose}{needed}; {again}")


def _again(found: Diagnosis, one: Named) -> str:
    """What a second recording says of a name."""
    if one.evidence is Transfer.TRANSFERRED:
        return "a second recording agrees"
    if not found.second:
        return "one recording; confirm with a second"
    return "the second recording does not bear it out" if one.askable else "one recording; a second cannot tell"


def _row(one: Named) -> dict[str, Any]:
    lines = [
        f"{name} = {value} {unit}" if low is None else f"{name} = {value} [{low} to {high}] {unit}"
        for name, value, low, high, unit in parameter_rows(one)
    ]
    strength = f"{one.strength:.2g} sigma, {one.nats:.3g} nats" if one.how in FITTED and one.nats else ""
    return {"name": one.name, "alternatives": one.others, "lines": lines, "how": one.how.words,
            "evidence": ", ".join(filter(None, (strength, one.evidence)))}  # fmt: skip
