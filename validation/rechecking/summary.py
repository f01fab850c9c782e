"""The answer on an old calibration in words, as table rows, and as JSON."""

from __future__ import annotations

from typing import Any

import numpy as np

from scenarios.plain import json_ready
from validation.rechecking.parts import INTERVAL_Z, JOINT, OFFSET, SCALE, PartChange
from validation.rechecking.recheck import Recheck
from validation.text import figure, listed, measured

HEADS = ("part", "change (95 %)", "unit", "heading error", "chance without a change")
SMALLEST_DEG = 1e-3
"""Heading errors below are told as less: no survey notices."""


def summary(found: Recheck) -> dict[str, Any]:
    """Return verdict, changes and figures as plain values; null for what is not known."""
    value, low, high = found.heading_deg
    plain = {
        "verdict": found.verdict,
        "sentence": headline(found),
        "tolerance_deg": found.tolerance_deg,
        "heading_error_deg": {"value": value, "low": low, "high": high},
        "excluded_deg": found.excluded_deg,
        "offset_change_found_nT" if found.unit == "nT" else "offset_change_found_counts": found.found_nT,
        "changes": [_plain(one) for one in found.changes],
        "parts": [_plain(one) for one in found.parts],
        "knowledge": found.knowledge,
        "reason": found.reason,
        "notes": list(found.notes),
    }
    return json_ready(plain)  # type: ignore[no-any-return]


def _plain(one: PartChange) -> dict[str, Any]:
    wide = INTERVAL_Z * one.std
    return {
        "what": one.what,
        "value": one.value,
        "low": one.value - wide,
        "high": one.value + wide,
        "std": one.std,
        "unit": one.unit,
        "heading_error_deg": one.heading_deg,
        "any_attitude_deg": one.angle_deg,
        "chance": one.chance,
        "significant": one.significant,
    }


def headline(found: Recheck) -> str:
    """Return the verdict in a sentence, with what was found or excluded."""
    value, low, high = (figure(one, 2) for one in found.heading_deg)
    tolerance = figure(found.tolerance_deg, 2)
    if found.verdict == "cannot tell":
        return f"cannot tell: {found.reason}"
    if found.verdict == "valid":
        small = [_part_text(one) for one in found.changes]
        beside = f"; a change too small to matter: {listed(small)}" if small else ""
        size = f"an offset change of {figure(found.found_nT, 2)} {found.unit} would have shown"
        excluded = f"a change of the heading by {figure(found.excluded_deg, 2)} deg is excluded"
        return f"valid: {excluded} (tolerance {tolerance} deg, 99 %), {size} (95 %){beside}"
    named = listed([_part_text(one) for one in found.changes])
    matters = "within" if found.excluded_deg < found.tolerance_deg else "not within"
    return f"changed: {named}; heading error {value} deg [{low}, {high}], {matters} the tolerance of {tolerance} deg"


def _part_text(one: PartChange) -> str:
    """Return "offset by (900 +- 10, ...) nT"; the largest entry of a matrix or of motors."""
    if one.what in (OFFSET, SCALE, JOINT):
        each = [f"{figure(v)} ± {figure(INTERVAL_Z * s, 2)}" for v, s in zip(one.value, one.std, strict=True)]
        values = each[0] if len(each) == 1 else f"({', '.join(each)})"
        return f"{one.what} by {values} {one.unit}"
    k = int(np.argmax(np.abs(one.value)))
    return f"{one.what} by up to {figure(abs(one.value[k]))} ± {figure(INTERVAL_Z * one.std[k], 2)} {one.unit}"


def rows(found: Recheck) -> list[list[str]]:
    """Return a row a part, cells of HEADS."""
    table = []
    for one in found.parts:
        values = ", ".join(measured(v, INTERVAL_Z * s) for v, s in zip(one.value, one.std, strict=True))
        chance = "< 0.0001" if one.chance < 1e-4 else figure(one.chance, 2)
        small = one.heading_deg < SMALLEST_DEG
        error = f"< {figure(SMALLEST_DEG)}°" if small else f"{figure(one.heading_deg, 2)}°"
        table.append([one.what, values, one.unit, error, chance])
    return table
