"""Next legs after a recording in words and as JSON."""

from __future__ import annotations

from math import isfinite
from typing import Any

from scenarios.plain import json_ready
from validation.planning.next_leg import LegSequence, NextLeg
from validation.planning.summary import PERFECT, field_of, field_words, leg_summary, limit_of, row, times_s
from validation.text import duration, quantity


def summary(found: LegSequence, scenario: str) -> dict[str, Any]:
    """Return the JSON of `--json`; scenario : file with the legs, "" if no leg pays."""
    goal = found.task.goal
    least = found.least
    plain = {
        "scenario": scenario or None,
        "field_enu_nT": field_of(found.task),
        "predicted": {goal.name: found.error, "before": found.task.error_before},
        "limit": None if least is None else {goal.name: least.value, "duality_gap": least.gap},
        "legs": [_leg(leg, found) for leg in found.legs],
        "no_longer_pays": None if found.idle is None else _leg(found.idle, found),
    }
    return json_ready(plain)  # type: ignore[no-any-return]


def headline(found: LegSequence) -> str:
    """Return the gain of each leg, the first leg that does not pay, and the error from recording and legs."""
    goal = found.task.goal
    lines = [f"leg {number}: {_gain(leg, found)}" for number, leg in enumerate(found.legs, start=1)]
    if found.idle is not None:
        lines.append(f"a further leg does not pay: {_gain(found.idle, found)}")
    lines.append(field_words(found.task))
    if found.error is not None and found.least is not None:
        size = quantity(found.error, goal.unit)
        lines.append(f"recording and simulated legs determine the {goal.short} to {size} rms")
        lines.append(limit_of(found.least))
        lines += [PERFECT] if found.task.linked else []
    return "\n".join(lines)


def rows(found: LegSequence) -> list[tuple[str, ...]]:
    """Return a row for each attitude, numbered by leg; times from the start of the leg."""
    return [
        row(f"{number}.{place}", attitude, begin, length)
        for number, leg in enumerate(found.legs, start=1)
        for place, (attitude, (begin, length)) in enumerate(
            zip(leg.choice.legs, times_s(leg.choice), strict=True), start=1
        )
    ]


def _gain(leg: NextLeg, found: LegSequence) -> str:
    unit, length = found.task.goal.unit, duration(leg.choice.phase.duration_s)
    before = quantity(leg.before, unit) if isfinite(leg.before) else f"an undetermined {found.task.goal.short}"
    return f"in {length} {before} becomes {quantity(leg.after, unit)}"


def _leg(leg: NextLeg, found: LegSequence) -> dict[str, Any]:
    unit = found.task.goal.unit
    shown = [leg_summary(one, times) for one, times in zip(leg.choice.legs, times_s(leg.choice), strict=True)]
    sizes = {f"before_{unit}": leg.before, f"after_{unit}": leg.after, f"gain_{unit}": leg.gain}
    return sizes | {"lasts_s": leg.choice.phase.duration_s, "attitudes": shown}
