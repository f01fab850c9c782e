"""What one scenario gave in the end: handed to the report and to the rerun recording."""

from __future__ import annotations

import itertools
from dataclasses import dataclass, field

import numpy as np

from calib.result import Calibration
from recordings.metadata import Tracking
from recordings.recording import Recording, Truth
from scenarios.arrays import Array
from sim.scenario import Scenario
from validation.scoring.recommendation import Recommendation, recommend
from validation.scoring.scores import Score

RANKED_BY = "holdout_level_component_rms"
"""The score that orders calibrators: the whole field vector on a level survey, the motion that a vehicle measures in,
which the fit has not seen. How well a calibrator does in attitudes that a survey never takes stands beside it."""


@dataclass(frozen=True, repr=False)
class Outcome:
    """One simulated run with every calibrator's answer.

    calibrations: by calibrator, in the scenario's order; scores: likewise, and last the raw measurement's, which is no
    calibrator and is never ranked; `corrected`: the corrected field (n, 3) in nT, body
    frame, by calibrator, for those that gave one. `tracking`: how well the vehicle followed its path, None where it
    follows none; `needs`: what each calibrator needs of a recording. Of an array of sensors the pictures show sensor 1.
    """

    scenario: Scenario
    recording: Recording
    truth: Truth
    calibrations: dict[str, Calibration]
    scores: dict[str, list[Score]]
    corrected: dict[str, Array]
    tracking: Tracking | None = None
    needs: dict[str, tuple[str, ...]] = field(default_factory=dict)

    def __repr__(self) -> str:
        """One line: the scenario, which calibrator to use, and how many failed."""
        found = self.answer()
        failed = f"; {len(found.failed)} of {len(self.calibrations)} failed" if found.failed and found.use else ""
        return f"{self.scenario.name}: {found.sentence}{failed}"

    def answer(self) -> Recommendation:
        """Which calibrator this run speaks for."""
        order, by = self.ranking()
        return recommend(self.calibrations, self.scores, by, order)

    @property
    def sensors(self) -> int:
        """Number of magnetometers in the recording."""
        array = self.recording.array_mag_nT
        return 1 if array is None else len(array)

    @property
    def effects(self) -> dict[str, Array]:
        """Contribution (n, 3) of each effect to sensor 1, in nT, in the order of the chain."""
        return {name: value if value.ndim == 2 else value[0] for name, value in self.truth.effects.items()}

    @property
    def field_strength_nT(self) -> float:
        """Strength of the undisturbed field: the radius of the reference sphere."""
        return float(np.nanmedian(np.linalg.norm(self.truth.field_nT, axis=1)))

    def ranking(self) -> tuple[list[str], str]:
        """Calibrators from best to worst, and the score that ordered them ("" when there is none).

        Those with status "ok" first, lowest score first. The score is RANKED_BY, or else the first in nT that is not
        in-sample.
        """
        by = self._ranked_by()

        def place(name: str) -> tuple[bool, float]:
            return self.calibrations[name].status.kind != "ok", self._value(name, by)

        return sorted(self.calibrations, key=place), by

    def rows(self) -> list[str]:
        """What tables show: calibrators from best to worst, then the raw measurement."""
        return [*self.ranking()[0], *(name for name in self.scores if name not in self.calibrations)]

    def _ranked_by(self) -> str:
        """The score that orders calibrators, "" where none may."""
        ranked = [score for name in self.calibrations for score in self.scores.get(name, [])]
        fair = [score.name for score in ranked if not score.in_sample and score.unit == "nT"]
        return RANKED_BY if RANKED_BY in fair else (fair or [""])[0]

    def _value(self, name: str, score: str) -> float:
        """A calibrator's score, infinity where it has none."""
        values = (s.value for s in self.scores.get(name, []) if s.name == score and np.isfinite(s.value))
        return next(values, np.inf)

    def shown(self) -> list[str]:
        """Calibrators that pictures show: with an estimate, best first; of an array (name@sensor) sensor 1's."""
        given = [c for c in self.ranking()[0] if c in self.corrected]
        usable = [c for c in given if self.calibrations[c].status.kind != "not_applicable"]
        return [c for c in usable if "@" not in c or c.endswith("@1")]

    def rotation_removed(self, name: str) -> bool:
        """Whether this calibrator's scores leave out the rotation that the field's strength cannot tell."""
        return any(score.rotation_removed for score in self.scores.get(name, []))

    def residual_nT(self, name: str) -> Array:
        """Corrected field minus truth (n, 3), body frame: Q h_cal - h.

        Q is I, or, where the scores leave a rotation out, the rotation that brings the corrected field closest to the
        truth (orthogonal Procrustes on this recording).
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
        """Whether the vehicle leaves its place: otherwise there is no path to draw."""
        return float(np.max(np.ptp(self.truth.pos_enu_m, axis=0))) > 0.1

    def phases(self) -> list[tuple[str, int, int]]:
        """Consecutive stretches (label, first sample, one past the last) of the motion."""
        phase = self.recording.phase
        if phase is None:
            return [("motion", 0, len(self.recording))]
        cuts = [0, *(np.flatnonzero(phase[1:] != phase[:-1]) + 1).tolist(), len(phase)]
        return [(str(phase[a]), a, b) for a, b in itertools.pairwise(cuts) if b > a]
