"""Outcome of a scenario run, for the report and the viewer recording."""

from __future__ import annotations

import itertools
from dataclasses import dataclass, field
from typing import TYPE_CHECKING

import numpy as np

from calib.result import Calibration
from recordings.metadata import Tracking
from recordings.recording import Recording, Truth
from scenarios.arrays import Array
from validation.scoring.recommendation import Recommendation, recommend
from validation.scoring.scores import Score

if TYPE_CHECKING:
    from sim.scenario import Scenario

RANKED_BY = "holdout_level_component_rms"
"""The score that ranks calibrators: rms error of the field vector on a level survey, a motion that was not fitted and
in which a vehicle measures. Errors over all attitudes are shown in addition."""


@dataclass(frozen=True, repr=False)
class Outcome:
    """A simulated run with the calibrations and scores of every calibrator.

    calibrations : by calibrator, in the order of the scenario. scores : likewise, and last the raw measurement, which
    is never ranked. corrected : the corrected field (n, 3), nT, body frame, by calibrator with an estimate.
    tracking : how well the vehicle followed the path, None without a path. needs : signals needed by each calibrator.
    asked : the scenario as the caller named it and the changed values KEY=VALUE; ("",) for a scenario made in Python.
    Pictures of a sensor array show sensor 1.
    """

    scenario: Scenario
    recording: Recording
    truth: Truth
    calibrations: dict[str, Calibration]
    scores: dict[str, list[Score]]
    corrected: dict[str, Array]
    tracking: Tracking | None = None
    needs: dict[str, tuple[str, ...]] = field(default_factory=dict)
    asked: tuple[str, ...] = ("",)

    def __repr__(self) -> str:
        """Return a line: scenario, recommended calibrator, number of failures."""
        found = self.answer()
        failed = f"; {len(found.failed)} of {len(self.calibrations)} failed" if found.failed and found.use else ""
        return f"{self.scenario.name}: {found.sentence}{failed}"

    def answer(self) -> Recommendation:
        """Return the recommended calibrator of the run."""
        order, by = self.ranking()
        return recommend(self.calibrations, self.scores, by, order)

    @property
    def sensors(self) -> int:
        """Number of magnetometers in the recording."""
        array = self.recording.array_mag_nT
        return 1 if array is None else len(array)

    @property
    def effects(self) -> dict[str, Array]:
        """Contribution (n, 3) of each effect to sensor 1, nT, in the order of the chain."""
        return {name: value if value.ndim == 2 else value[0] for name, value in self.truth.effects.items()}

    @property
    def field_strength_nT(self) -> float:
        """Strength of the undisturbed field: the radius of the reference sphere."""
        return float(np.nanmedian(np.linalg.norm(self.truth.field_nT, axis=1)))

    def ranking(self) -> tuple[list[str], str]:
        """Return the calibrators from best to worst and the name of the ranking score ("" for none).

        Calibrators of status "ok" come first, by ascending score. The score is RANKED_BY, else the first out-of-sample
        score in nT.
        """
        by = self._ranked_by()

        def place(name: str) -> tuple[bool, float]:
            return self.calibrations[name].status.kind != "ok", self._value(name, by)

        return sorted(self.calibrations, key=place), by

    def rows(self) -> list[str]:
        """Return the rows of tables: calibrators of status "ok", then the failed and the raw measurement."""
        ranked, by = self.ranking()
        sound = [name for name in ranked if self.calibrations[name].status.kind == "ok"]
        raw = [name for name in self.scores if name not in self.calibrations]
        return sound + sorted([*ranked[len(sound) :], *raw], key=lambda name: self._value(name, by))

    def _ranked_by(self) -> str:
        """Return the name of the ranking score, "" where no score may rank."""
        ranked = [score for name in self.calibrations for score in self.scores.get(name, [])]
        fair = [score.name for score in ranked if not score.in_sample and score.unit == "nT"]
        return RANKED_BY if RANKED_BY in fair else (fair or [""])[0]

    def _value(self, name: str, score: str) -> float:
        """Return a score of a calibrator, infinite where missing."""
        return next((s.value for s in self.scores.get(name, []) if s.name == score and np.isfinite(s.value)), np.inf)

    def shown(self) -> list[str]:
        """Return the calibrators shown in pictures: with an estimate, best first; of an array, sensor 1."""
        given = [c for c in self.ranking()[0] if c in self.corrected]
        usable = [c for c in given if self.calibrations[c].status.kind != "not_applicable"]
        return [c for c in usable if "@" not in c or c.endswith("@1")]

    def rotation_removed(self, name: str) -> bool:
        """Return whether the calibrator's scores leave out the rotation not determined by the field strength."""
        return any(score.rotation_removed for score in self.scores.get(name, []))

    def residual_nT(self, name: str) -> Array:
        """Return the residual Q h_cal - h (n, 3), nT, body frame.

        Q is I; where scores leave out a rotation, Q is the rotation that brings the corrected field closest to the
        truth (orthogonal Procrustes on the recording).
        """
        corrected, truth = self.corrected[name], self.truth.field_nT
        if not self.rotation_removed(name):
            return corrected - truth
        whole = np.isfinite(corrected).all(axis=1)
        u, _, vt = np.linalg.svd(truth[whole].T @ corrected[whole])
        rotation = u @ np.diag([1.0, 1.0, np.linalg.det(u @ vt)]) @ vt
        return np.asarray(corrected @ rotation.T - truth)

    @property
    def travels(self) -> bool:
        """Whether the vehicle moves by more than 0.1 m, so a path can be drawn."""
        return float(np.max(np.ptp(self.truth.pos_enu_m, axis=0))) > 0.1

    def phases(self) -> list[tuple[str, int, int]]:
        """Return the phases of the motion as (label, first sample, end sample)."""
        phase = self.recording.phase
        if phase is None:
            return [("motion", 0, len(self.recording))]
        cuts = [0, *(np.flatnonzero(phase[1:] != phase[:-1]) + 1).tolist(), len(phase)]
        return [(str(phase[a]), a, b) for a, b in itertools.pairwise(cuts) if b > a]
