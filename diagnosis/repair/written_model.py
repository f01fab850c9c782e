"""The gap that remains when the simulator runs the written model along the recorded motion."""

from __future__ import annotations

import numpy as np

from diagnosis.problem.formulation import pose_model
from diagnosis.problem.linear import LinearProblem
from recordings import Recording
from scenarios.nesting import parsed_toml
from scenarios.toml import to_toml
from sim.scenario import Scenario
from validation.signals.amplitude import rms


def resimulated_rms_nT(recording: Recording, model: Scenario, end: LinearProblem) -> float | None:
    """Rms in nT of measured minus simulated for a model read back from its TOML text, with no fit to the recording.

    recording : with its attitude as recorded. end : the problem at the end of the diagnosis, whose usable samples are
    counted. None where the three axes are not compared with the Earth's field.
    """
    if end.mode != "vector" or end.still or end.relative or len(end.usable) != len(recording):
        return None
    read = Scenario.model_validate(parsed_toml(to_toml(model), "model.toml", "report the model"))
    posed = pose_model(recording, read, None, None, policy=end.policy)
    return rms((posed.recording.mag_nT - posed.predicted_nT)[np.asarray(end.usable > 0)])
