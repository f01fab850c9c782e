"""The bound in words and as JSON."""

from __future__ import annotations

from dataclasses import asdict
from math import isfinite
from typing import Any

from scenarios.plain import json_ready
from validation.bound.bound import Bound
from validation.bound.experiment import Experiment
from validation.bound.information import AXES
from validation.bound.uses import Use
from validation.bound.weak import Weak, observable
from validation.text import figure, quantity

Row = tuple[str, ...]
NOT_TOLD = "not told"
"""Of a figure of which the motion says nothing."""


def summary(known: Experiment, bound: Bound, used: tuple[Use, ...], weak: tuple[Weak, ...]) -> dict[str, Any]:
    """What `--json` prints; null where a motion says nothing."""
    told = {
        "knowledge": bound.knowledge,
        "noise_std_nT": known.noise_std_nT,
        "samples": len(known.field_nT),
        "offset_std_nT": bound.offset_std_nT,
        "offset_rms_nT": bound.offset_rms_nT,
        "matrix_std": bound.matrix_std,
        "scores": {one.meaning.column: one.value for one in used},
        "observable": observable(known, bound),
        "unobservable": [asdict(one) for one in weak],
    }
    return json_ready(told)  # type: ignore[no-any-return]


def headline(known: Experiment, bound: Bound, weak: tuple[Weak, ...]) -> str:
    """The answer in a sentence, and for each weak direction what, why and what helps."""
    size = bound.offset_rms_nT
    told = (
        f"no method can find the offset to less than {figure(size)} nT rms"
        if size < float("inf")
        else ("no method can find the whole offset")
    )
    lines = [f"{told} from {len(known.field_nT):,} samples with {figure(known.noise_std_nT)} nT of white noise"]
    lines += [f"not told apart: {one.what}; {one.why}" for one in weak]
    lines += list(dict.fromkeys(one.remedy for one in weak))
    return "\n".join(lines)


def rows(bound: Bound) -> list[Row]:
    """A row an axis: the standard deviations of the offset's component and of the matrix's row."""
    found = zip(AXES, bound.offset_std_nT, bound.matrix_std, strict=True)
    return [(axis, figure(offset), *(f"{value:.3g}" for value in matrix)) for axis, offset, matrix in found]


def use_rows(used: tuple[Use, ...]) -> list[Row]:
    """A row a score: its name, the least of it, and what it is."""
    return [
        (
            one.meaning.short,
            quantity(one.value, one.meaning.unit) if isfinite(one.value) else NOT_TOLD,
            one.meaning.explained,
        )
        for one in used
    ]
