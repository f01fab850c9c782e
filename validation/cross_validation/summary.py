"""The answer in words and as JSON."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import asdict
from math import inf
from typing import Any

from scenarios.plain import json_ready
from validation.cross_validation.claimed_std import Claim
from validation.cross_validation.models import OFFSET
from validation.cross_validation.paired_legs import ModelPair
from validation.cross_validation.workflow import UNTOLD, Worth
from validation.text import figure, sentence

CALLED = {OFFSET: "the offset alone"}
"""Names for sentences, where they are others than "the ..."."""


def summary(found: Worth) -> dict[str, Any]:
    """What `--json` prints."""
    told = {
        "sensor": found.sensor,
        "knowledge": found.knowledge,
        "legs": found.legs.count,
        "legs_by": found.legs.how,
        "keep": found.keep,
        "comparisons": [_plain(one) for one in found.pairs],
    }
    return json_ready(told)  # type: ignore[no-any-return]


def claim_summary(claims: Mapping[str, Claim]) -> dict[str, Any]:
    """The claims of calibrators by name, as `--json` prints them."""
    return {name: asdict(one) | {"sentence": one.sentence} for name, one in claims.items()}


def claim_lines(claims: Mapping[str, Claim]) -> list[str]:
    """A line for each that cannot be believed as it is."""
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
        "sentence": told(one),
    }


def headline(found: Worth) -> str:
    """A sentence a pair, and what was held out."""
    of = found.sensor.replace("sensor@", "sensor ") + ": " if "@" in found.sensor else ""
    how = f"held out in turn: {found.legs.count} legs, by {found.legs.how}; known: the field's {found.knowledge}"
    take = f"take {_called(found.keep)}" if found.keep else f"take none of them: {UNTOLD}"
    return "\n".join(of + sentence(text) for text in (*(told(one) for one in found.pairs), take, how))


def told(one: ModelPair) -> str:
    """Whether the richer model is worth it, by how much and how sure."""
    richer, simpler = _called(one.richer.model.name), _called(one.simpler.model.name)
    size, rms = figure(abs(one.better_nT)), (figure(one.simpler.typical_nT), figure(one.richer.typical_nT))
    more = one.richer.model.count - one.simpler.model.count
    if one.doubt and one.interval_nT[0] > 0:
        return f"cannot tell: {richer} predicts unseen legs {size} nT better than {simpler}, but {one.doubt}"
    match one.verdict:
        case "worth_it":
            what = f"{richer} predicts unseen legs {size} nT better than {simpler}"
            return f"{what} ({_interval(one)}; {rms[0]} nT become {rms[1]}): worth it"
        case "worse":
            return f"{richer} predicts unseen legs {size} nT worse than {simpler} ({_interval(one)}): leave it"
        case "as_well":
            what = f"{simpler} predicts unseen legs as well as {richer}"
            return f"{what} ({_interval(one)}): {more} more parameters only add noise"
    return f"cannot tell whether {richer} predicts unseen legs better than {simpler}: {_interval(one)}"


def _interval(one: ModelPair) -> str:
    """Of the gain, and what it is from; the legs alone where they tell none."""
    count, (low, high) = len(one.gain_nT), one.interval_nT
    counted = "" if one.counted > count - 1 else f" that count for {figure(one.counted, 2)}"
    told = f"{figure(low)} to {figure(high)} nT over " if abs(high) < inf else ""
    return f"{told}{count} legs{counted}"


def _called(name: str) -> str:
    return CALLED.get(name, f"the {name}")
