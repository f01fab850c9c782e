"""Goal of a motion: the figure of merit to minimise."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from scenarios.arrays import Array
from scenarios.errors import InputError
from scenarios.names import closest
from validation.bound.experiment import Experiment
from validation.bound.knowledge import PLACES
from validation.bound.score_bounds import ROWS, rows_of
from validation.scoring.definitions import SCORE_DEFINITIONS


@dataclass(frozen=True)
class Goal:
    """Figure of merit: name with unit, and the score of a calibration with the figure as rms over trials."""

    name: str
    score: str
    unit: str

    @property
    def short(self) -> str:
        """Return the name for a sentence."""
        return SCORE_DEFINITIONS[self.score].short

    def factor(self, known: Experiment, knowledge: str) -> Array:
        """Return B (k, q) with ``tr B^T C B`` the mean square of the figure, C the covariance of the parameters."""
        if self is OFFSET:
            return np.eye(3 + len(PLACES[knowledge]))[:, :3]
        rows = rows_of(self.score, known, knowledge)
        values, vectors = np.linalg.eigh(rows.T @ rows / len(rows))
        return np.asarray(vectors * np.sqrt(np.clip(values, 0.0, None)))


OFFSET = Goal("offset_rms_nT", "offset_error", "nT")
GOALS = {
    goal.name: goal
    for goal in (OFFSET, *(Goal(SCORE_DEFINITIONS[n].column, n, SCORE_DEFINITIONS[n].unit) for n in ROWS))
}


def parsed_target(text: str, where: str) -> tuple[Goal, float]:
    """Read "offset_rms_nT=2"; InputError for an unknown figure, and a value that is not positive."""
    name, _, value = (part.strip() for part in text.partition("="))
    if name not in GOALS:
        raise InputError(f"no figure is called {name!r}", where=where, do=closest(name, GOALS))
    try:
        number = float(value)
    except ValueError:
        number = np.nan
    if not 0 < number < np.inf:
        raise InputError(f"{value!r} is not a positive number", where=where, do=f"write {name}=2")
    return GOALS[name], number
