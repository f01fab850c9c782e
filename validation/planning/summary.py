"""Plan in words and as JSON."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from scenarios.plain import json_ready
from validation.bound.limit import Limit
from validation.planning.manoeuvre import Leg
from validation.planning.plan import Plan
from validation.planning.search import LegSelection
from validation.planning.task import PlanningTask
from validation.text import counted, duration, figure, quantity

COMPASS = ("east", "north-east", "north", "north-west", "west", "south-west", "south", "south-east")
LEVEL_DEG = 0.5
"""Tilt below which an attitude is called level."""
AGREES = 1.15
"""Ratio of trial error to prediction above which noise is not only white: a hundred trials have an error of 6 %, and
calibrators come within a few per cent of the bound."""
PERFECT = (
    "the limit assumes a gyro without noise and bias, which links all samples: no motion is below the limit, and none "
    "with this gyro reaches the limit"
)
LIMITS = ("limit of", "size", "ratio of this plan", "duality gap, %")
"""Heads of the table of limits."""
HEADS = ("leg", "attitude", "yaw, °", "pitch, °", "roll, °", "from, s", "for, s")


def field_words(task: PlanningTask) -> str:
    """Return the field that is planned for, in a sentence: east, north, up, and where the vertical part points."""
    assert task.known.field_enu_nT is not None
    east, north, up = task.known.field_enu_nT
    where = "up, as in the southern hemisphere" if up > 0 else "down, as in the northern hemisphere"
    strength = f"{np.linalg.norm(task.known.field_enu_nT):.0f} nT"
    return f"planned for a field of {east:.0f}, {north:.0f}, {up:.0f} nT east, north, up ({strength}), pointing {where}"


def field_of(task: PlanningTask) -> list[float] | None:
    """Return the field that is planned for as JSON: east, north, up in nT."""
    return None if task.known.field_enu_nT is None else [float(part) for part in task.known.field_enu_nT]


def summary(found: Plan, scenario: str) -> dict[str, Any]:
    """Return the JSON of `--json`; scenario : file with the manoeuvre."""
    goal = found.task.goal.name
    plain: dict[str, Any] = {
        "scenario": scenario,
        "field_enu_nT": field_of(found.task),
        "predicted": {
            goal: found.error,
            "time_s": found.time_s,
            "met": found.met,
            **{one.meaning.column: one.value for one in found.answer.used},
        },
        "limit": {
            goal: found.least.value,
            "ratio": found.ratio,
            "duality_gap": found.least.gap,
            "staying": _staying(found),
            "roll_deg": found.task.tilts.roll_deg,
            "pitch_deg": found.task.tilts.pitch_deg,
            "flown_roll_deg": found.flown_deg[0],
            "flown_pitch_deg": found.flown_deg[1],
        },
        "legs": [leg_summary(leg, times) for leg, times in zip(found.choice.legs, times_s(found.choice), strict=True)],
    }
    if found.confirmed is not None:
        one = found.confirmed
        plain["confirmed"] = {
            goal: one.error,
            "calibrator": one.calibrator,
            "trials": one.trials,
            "failures": one.failures,
        }
    return json_ready(plain)  # type: ignore[no-any-return]


def headline(found: Plan) -> str:
    """Return the predicted error, the ratio to the limit, and the result of trials."""
    unit = found.task.goal.unit
    size = quantity(found.error, unit)
    legs = counted(len(found.choice.legs), "attitude")
    lines = [f"{legs} in {duration(found.time_s)} determine the {found.task.goal.short} to {size} rms"]
    lines.append(field_words(found.task))
    if found.target is not None and not found.met:
        lines.append(f"the target of {quantity(found.target, unit)} is not met: give more --time")
    lines.append(f"{limit_of(found.least)}, this plan has {figure(found.ratio)} times the limit")
    lines += [PERFECT] if found.task.linked else []
    if found.staying is not None and found.staying_ratio is not None:
        lines.append(f"{_staying_limit_of(found.staying)}, this plan has {figure(found.staying_ratio)} times the limit")
    if found.confirmed is not None:
        one = found.confirmed
        failed = f", {one.failures} failed" if one.failures else ""
        lines.append(f"flown {one.trials} times, {one.calibrator} is off by {quantity(one.error, unit)} rms{failed}")
    return "\n".join(lines)


def _staying(found: Plan) -> dict[str, float | None] | None:
    least = found.staying
    if least is None:
        return None
    return {least.goal.name: least.value, "ratio": found.staying_ratio, "duality_gap": least.gap}


def limit_of(least: Limit) -> str:
    """Return the limit of tilts in a sentence."""
    within = f"within a roll of {least.tilts.roll_deg:g} and a pitch of {least.tilts.pitch_deg:g} degrees"
    return (
        f"the limit of any motion {within} in this time is {quantity(least.value, least.goal.unit)} ({least.gap_words})"
    )


def _staying_limit_of(least: Limit) -> str:
    size = quantity(least.value, least.goal.unit)
    return f"the limit of a vehicle that tilts only by thrust and remains in place is {size} ({least.gap_words})"


def limits(found: Plan) -> list[tuple[str, ...]]:
    """Return a row for each limit, with heads LIMITS: for any motion, and for vehicles that remain in place."""
    named = [("any motion within the tilts", found.least, found.ratio)]
    if found.staying is not None and found.staying_ratio is not None:
        named.append(("a vehicle that tilts only by thrust, in place", found.staying, found.staying_ratio))
    return [
        (whose, quantity(least.value, least.goal.unit), figure(ratio), figure(100 * least.gap, 2))
        for whose, least, ratio in named
    ]


def rows(found: Plan) -> list[tuple[str, ...]]:
    """Return a row for each leg: attitude, angles and times."""
    return [
        row(str(number), leg, begin, length)
        for number, (leg, (begin, length)) in enumerate(
            zip(found.choice.legs, times_s(found.choice), strict=True), start=1
        )
    ]


def row(name: str, leg: Leg, begin: float, length: float) -> tuple[str, ...]:
    """Return a row of a table with heads HEADS."""
    return (name, attitude(leg), *(f"{angle:g}" for angle in leg.angles_deg), figure(begin), figure(length))


def attitude(leg: Leg) -> str:
    """Return an attitude in words, as "facing north-east, nose 25° down, right side 20° down"."""
    parts = [f"facing {COMPASS[round(leg.yaw_deg / 45.0) % 8]}"]
    if abs(leg.pitch_deg) > LEVEL_DEG:
        parts.append(f"nose {abs(leg.pitch_deg):g}° {'down' if leg.pitch_deg > 0 else 'up'}")
    if abs(leg.roll_deg) >= 180.0 - LEVEL_DEG:
        parts.append("upside down")
    elif abs(leg.roll_deg) > LEVEL_DEG:
        parts.append(f"{'right' if leg.roll_deg > 0 else 'left'} side {abs(leg.roll_deg):g}° down")
    return ", ".join(parts if len(parts) > 1 else [*parts, "level"])


def times_s(choice: LegSelection) -> Sequence[tuple[float, float]]:
    """Return start and duration of each attitude."""
    return choice.task.manoeuvre.times_s(choice.phase)


def leg_summary(leg: Leg, times: tuple[float, float]) -> dict[str, Any]:
    yaw, pitch, roll = leg.angles_deg
    angles = {"yaw_deg": yaw, "pitch_deg": pitch, "roll_deg": roll, "begins_s": times[0], "lasts_s": times[1]}
    return {"attitude": attitude(leg), **angles}
