"""Result of the cross-validation in words and as JSON."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import asdict
from math import inf
from typing import Any

from calib.held_out.models import OFFSET
from calib.held_out.paired_legs import ModelPair
from scenarios.plain import json_ready
from validation.cross_validation.claimed_std import Claim
from validation.cross_validation.workflow import UNDETERMINED, CrossValidation
from validation.text import figure, sentence

CALLED = {OFFSET: "the offset alone"}
"""Names in sentences, if different from "the ..."."""


def summary(found: CrossValidation) -> dict[str, Any]:
    """Return the JSON of `--json`."""
    plain = {
        "sensor": found.sensor,
        "knowledge": found.knowledge,
        "legs": found.legs.count,
        "legs_by": found.legs.how,
        "keep": found.keep,
        "comparisons": [_plain(one) for one in found.pairs],
    }
    return json_ready(plain)  # type: ignore[no-any-return]


def claim_summary(claims: Mapping[str, Claim]) -> dict[str, Any]:
    """Return the claims of calibrators by name, for `--json`."""
    return {name: asdict(one) | {"sentence": one.sentence} for name, one in claims.items()}


def claim_lines(claims: Mapping[str, Claim]) -> list[str]:
    """Return a line for each doubtful claim."""
    return [f"{name}: {one.sentence}." for name, one in claims.items() if one.sentence]


def _plain(one: ModelPair) -> dict[str, Any]:
    low, high = one.interval_nT
    return {
        "model": one.richer.model.name,
        "parameters": one.richer.model.count,
        "against": one.simpler.model.name,
        "verdict": one.verdict,
        "better_nT": one.better_nT,
        "low_nT": low,
        "high_nT": high,
        "rms_nT": one.richer.typical_nT,
        "against_rms_nT": one.simpler.typical_nT,
        "legs_counted": one.counted,
        "doubt": one.doubt,
        "sentence": pair_sentence(one),
    }


def headline(found: CrossValidation) -> str:
    """Return a sentence for each pair, the recommended model, and the legs held out."""
    of = found.sensor.replace("sensor@", "sensor ") + ": " if "@" in found.sensor else ""
    how = f"held out in turn: {found.legs.count} legs, by {found.legs.how}; known: the field's {found.knowledge}"
    take = f"use {_called(found.keep)}" if found.keep else f"use none of these models: {UNDETERMINED}"
    return "\n".join(of + sentence(text) for text in (*(pair_sentence(one) for one in found.pairs), take, how))


def pair_sentence(one: ModelPair) -> str:
    """Return the verdict on a pair in a sentence, with gain and interval."""
    richer, simpler = _called(one.richer.model.name), _called(one.simpler.model.name)
    size, rms = figure(abs(one.better_nT)), (figure(one.simpler.typical_nT), figure(one.richer.typical_nT))
    more = one.richer.model.count - one.simpler.model.count
    if one.interval_nT[0] > 0 and not one.matters:
        what = f"{richer} predicts held-out legs only {size} nT better than {simpler}"
        return f"{what} ({_interval(one)}; {rms[0]} nT become {rms[1]}), too little to matter: use {simpler}"
    if one.doubt and one.interval_nT[0] > 0:
        return f"undecided: {richer} predicts held-out legs {size} nT better than {simpler}, but {one.doubt}"
    match one.verdict:
        case "worth_it":
            what = f"{richer} predicts held-out legs {size} nT better than {simpler}"
            return f"{what} ({_interval(one)}; {rms[0]} nT become {rms[1]}): use {richer}"
        case "worse":
            return f"{richer} predicts held-out legs {size} nT worse than {simpler} ({_interval(one)}): use {simpler}"
        case "as_well":
            what = f"{simpler} predicts held-out legs as well as {richer}"
            return f"{what} ({_interval(one)}): {more} more parameters only add noise"
    return f"undecided whether {richer} predicts held-out legs better than {simpler}: {_interval(one)}"


def _interval(one: ModelPair) -> str:
    """Return the interval of the gain and the number of legs; only the legs without an interval."""
    count, (low, high) = len(one.gain_nT), one.interval_nT
    counted = "" if one.counted > count - 1 else f" that count for {figure(one.counted, 2)}"
    interval = f"{figure(low)} to {figure(high)} nT over " if abs(high) < inf else ""
    return f"{interval}{count} legs{counted}"


def _called(name: str) -> str:
    return CALLED.get(name, f"the {name}")
