"""The new model as a file, and the gap that remains when the simulator runs the file along the recorded motion."""

from __future__ import annotations

import numpy as np

from diagnosis.problem.formulation import pose_model
from diagnosis.problem.linear import LinearProblem
from diagnosis.repair.new_model import StandIn
from recordings import Recording
from scenarios.nesting import parsed_toml
from scenarios.spec import NavigationSpec
from scenarios.toml import to_toml
from sim.scenario import ModelSpec, Scenario
from validation.signals.amplitude import rms

NO_VEHICLE = "# The vehicle is unknown: `diagnose --model` takes the file; to simulate, add [vehicle] and [[phases]].\n"


def written_model(model: Scenario) -> str:
    """The TOML text of a new model: a scenario, or what a diagnosis compares where the vehicle is not known."""
    if not isinstance(model, StandIn):
        return to_toml(model)
    kept = {name: getattr(model, name) for name in ("name", "summary", "field", "effects", "effect_order")}
    late = NavigationSpec(attitude_noise_std_deg=0.0, attitude_delay_s=model.navigation.attitude_delay_s)
    return NO_VEHICLE + to_toml(ModelSpec(navigation=late, **kept))


def resimulated_rms_nT(recording: Recording, model: Scenario, end: LinearProblem) -> float | None:
    """Rms in nT of measured minus simulated for a model read back from its TOML text, with no fit to the recording.

    recording : with its attitude as recorded. end : the problem at the end of the diagnosis, whose usable samples are
    counted. None where the three axes are not compared with the Earth's field.
    """
    if end.mode != "vector" or end.still or end.relative or len(end.usable) != len(recording):
        return None
    kind = ModelSpec if isinstance(model, StandIn) else Scenario
    read = kind.model_validate(parsed_toml(written_model(model), "model.toml", "report the model"))
    posed = pose_model(recording, read, None, None, policy=end.policy)
    return rms((posed.recording.mag_nT - posed.predicted_nT)[np.asarray(end.usable > 0)])
