"""The bound in words and as JSON."""

from __future__ import annotations

from dataclasses import asdict
from math import isfinite
from typing import Any

from scenarios.plain import json_ready
from validation.bound.colour import Colour
from validation.bound.information import AXES
from validation.bound.limit import Limit
from validation.bound.query import BoundAnswer, WhatIf
from validation.bound.score_bounds import ScoreBound
from validation.bound.unobservable import observable
from validation.text import figure, given, listed, quantity, symbol

Row = tuple[str, ...]
HEADS: Row = ("axis", "offset, nT", "S x", "S y", "S z")
"""Titles of `rows`."""
SCORE_HEADS: Row = ("at least", "error", "of what")
"""Titles of `score_rows`."""
NOT_OBSERVABLE = "unobservable"
"""Text for a figure that the motion does not determine."""


def summary(found: BoundAnswer) -> dict[str, Any]:
    """Return the JSON of `--json`, with null for unobservable figures."""
    plain = {
        "knowledge": found.bound.knowledge,
        "noise_std_nT": found.known.noise_std_nT,
        "samples": len(found.known.field_nT),
        "offset_std_nT": found.bound.offset_std_nT,
        "offset_rms_nT": found.bound.offset_rms_nT,
        "matrix_std": found.bound.matrix_std,
        **({} if found.bound.information.eddy_std_s is None else {"eddy_std_s": found.bound.information.eddy_std_s}),
        **({} if found.known.colour is None else asdict(found.known.colour)),
        "scores": {one.meaning.column: one.value for one in found.used},
        "observable": observable(found.known, found.bound),
        "unobservable": [asdict(one) for one in found.weak],
        **({} if found.limit is None else {"limit": limit_summary(found.limit)}),
    }
    return json_ready(plain)  # type: ignore[no-any-return]


def limit_summary(least: Limit) -> dict[str, Any]:
    """Return the limit of tilts, with the duality gap."""
    return {**asdict(least.tilts), least.goal.name: least.value, "duality_gap": least.gap}


def what_if_summary(found: WhatIf) -> dict[str, Any]:
    """Return the swept key, and the answer at each value."""
    points = [{"value": value, **summary(one)} for value, one in zip(found.values, found.answers, strict=True)]
    return {"key": found.key, "points": points}


def headline(found: BoundAnswer) -> str:
    """Return the bound in a sentence, and for each weak direction the parameters, the cause and a remedy."""
    size = found.bound.offset_rms_nT
    least = (
        f"no method can find the offset better than to {figure(size)} nT rms"
        if isfinite(size)
        else "no method can find the whole offset"
    )
    samples, noise = len(found.known.field_nT), figure(found.known.noise_std_nT)
    lines = [f"{least} from {samples} samples with {noise} nT of white noise{_beside(found.known.colour)}"]
    lines += [f"cannot be separated: {one.what}; {one.why}" for one in found.weak]
    lines += list(dict.fromkeys(one.remedy for one in found.weak))
    lines += [] if found.limit is None else [_limit(found.limit, size)]
    return "\n".join(lines)


def _beside(colour: Colour | None) -> str:
    """Return the coloured noise in words."""
    if colour is None:
        return ""
    flicker = f"{figure(colour.flicker_nT_sqrt_hz)} nT/√Hz of flicker noise" if colour.flicker_nT_sqrt_hz else ""
    walk = f"a random walk of {figure(colour.walk_nT_sqrt_s)} nT/sqrt(s)" if colour.walk_nT_sqrt_s else ""
    return " and " + listed([one for one in (flicker, walk) if one])


def _limit(least: Limit, size: float) -> str:
    """Return the limit in a sentence, and the ratio of the bound to the limit."""
    within = f"within a roll of {least.tilts.roll_deg:g} and a pitch of {least.tilts.pitch_deg:g} degrees"
    if not isfinite(least.value):
        return f"{within} no motion determines the offset"
    best = f"{within} no motion of as many samples can do better than {figure(least.value)} nT rms"
    times = f"; this one allows {figure(size / least.value)} times that" if isfinite(size) else ""
    return f"{best} ({least.gap_words}){times}"


def rows(found: BoundAnswer) -> list[Row]:
    """Return a row for each axis: standard deviations of offset and matrix row."""
    axes = zip(AXES, found.bound.offset_std_nT, found.bound.matrix_std, strict=True)
    return [(axis, figure(offset), *map(figure, matrix)) for axis, offset, matrix in axes]


def score_rows(used: tuple[ScoreBound, ...]) -> list[Row]:
    """Return a row for each score: name, bound and explanation."""
    return [(one.meaning.short, _figure(one.value, one.meaning.unit), one.meaning.explained) for one in used]


def what_if_heads(found: WhatIf) -> Row:
    """Return the titles of `what_if_rows`."""
    used = [f"{one.meaning.short}, {symbol(one.meaning.unit)}" for one in found.answers[0].used]
    return (found.key, *(f"offset {axis}, nT" for axis in AXES), "offset, nT rms", *used, "weak")


def what_if_rows(found: WhatIf) -> list[Row]:
    """Return a row for each value: standard deviations of the offset, score bounds, number of weak directions."""
    return [
        (
            given(value),
            *(_figure(std) for std in one.bound.offset_std_nT),
            _figure(one.bound.offset_rms_nT),
            *(_figure(use.value) for use in one.used),
            str(len(one.weak)),
        )
        for value, one in zip(found.values, found.answers, strict=True)
    ]


def what_if_headline(found: WhatIf) -> str:
    """Return the best of the tried values, compared with the worst, in a sentence."""
    sizes = {given(value): one.bound.offset_rms_nT for value, one in zip(found.values, found.answers, strict=True)}
    best, worst = min(sizes, key=sizes.__getitem__), max(sizes, key=sizes.__getitem__)
    if not isfinite(sizes[best]):
        return f"the offset cannot be determined at any of these values of {found.key}"
    other = f"at {worst} {_figure(sizes[worst], 'nT')}"
    return f"the offset error is least at {found.key} = {best}: {_figure(sizes[best], 'nT')} rms; {other}"


def _figure(value: float, unit: str = "") -> str:
    return quantity(value, unit) if isfinite(value) else NOT_OBSERVABLE
