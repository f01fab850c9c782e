"""The shortest leg to be flown next that would decide whether the heading error is below a tolerance."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from calib import Reference
from recordings import Recording
from scenarios.errors import InputError
from sim.scenario import load
from validation.assessment.heading_error import HeadingError
from validation.assessment.judgement import DecidingLeg
from validation.assessment.level_flight import LevelFlight
from validation.assessment.policy import ASSESSMENT
from validation.bound.files import experiment_of
from validation.bound.goal import GOALS
from validation.planning.manoeuvre import Leg
from validation.planning.search import RouteSearch
from validation.planning.task import HAND, PlanningTask
from validation.signals.thinning import every_nth
from validation.text import duration, listed

LIKE = "standard-full"
"""Scenario whose sampling the legs have."""
HEADING = "heading_rms"
"""Score that the legs are planned for."""
MOST_SAMPLES = 5_000
"""Samples of the recording that count beforehand."""
COUNTS, CLOSE_S = (1, 2, 4, 8), 5.0
"""Tried numbers of attitudes, and accuracy of the time: bounds of the search, which takes about a second."""
MOST_TOLD = 4
"""Attitudes that are told."""


def shortest_leg(
    recording: Recording, reference: Reference, error: HeadingError, tolerance_deg: float
) -> DecidingLeg | None:
    """Return the shortest leg after a recording, turned by hand, that leaves ASSESSMENT.decided of the tolerance.

    The planned error is that of white noise; it is multiplied by the ratio of the present error to the planned one
    before the leg. None where no leg of ASSESSMENT.longest_s does.
    """
    try:
        task = _task(recording, reference, error.flight)
        before = task.error_before
        worse = max(1.0, error.value / before) if np.isfinite(before) and before > 0 else 1.0
        target = ASSESSMENT.decided * tolerance_deg / worse
        search = RouteSearch(task, ASSESSMENT.longest_s, COUNTS)
        found = search.shortest(target, ASSESSMENT.longest_s, CLOSE_S)
    except (InputError, ArithmeticError, np.linalg.LinAlgError):
        return None
    if not found.error <= target:
        return None
    told = [_told(leg) for leg in found.legs[:MOST_TOLD]]
    more = len(found.legs) - len(told)
    attitudes = listed([*told, *([f"{more} more"] if more > 0 else [])])
    text = f"{duration(found.time_s)} more by hand would decide: {attitudes}"
    return DecidingLeg(text, float(found.time_s))


def _task(recording: Recording, reference: Reference, flight: LevelFlight) -> PlanningTask:
    """Return the planning task after a recording, by the strength."""
    thin = replace(recording.taken(every_nth(len(recording), MOST_SAMPLES)), att_q=None)
    field = reference.field_enu_nT or (0.0, flight.level_nT, float(-flight.strength_nT * np.sin(flight.dip_rad)))
    goal = next(goal for goal in GOALS.values() if goal.score == HEADING)
    task = PlanningTask.of(HAND, load(LIKE, ()), "norm", goal=goal)
    return task.after(experiment_of(thin, Reference.of_vector(field)))


def _told(leg: Leg) -> str:
    return f"heading {leg.yaw_deg:.0f}°, pitch {leg.pitch_deg:.0f}°, roll {leg.roll_deg:.0f}°"
