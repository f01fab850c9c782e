"""The question of a diagnosis: the model, the known field, and the channels of motors."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any, Self

import numpy as np

from diagnosis.policy import STANDARD, Policy
from diagnosis.problem.formulation import pose_model
from diagnosis.problem.linear import LinearProblem
from diagnosis.problem.sensors import BY_MODEL, model_of_sensor, needs_field, one_sensor, with_actuators
from diagnosis.sources import Source
from recordings import Recording
from recordings.channels import may_be_cause
from scenarios.arrays import Array
from scenarios.errors import errors_relocated
from sim.scenario import Model, ModelSpec, load_model
from validation.calibrating.reference import told_field

Field = tuple[Array | None, float | None]
"""The field vector (3,) and the strength in nT; None where unknown."""


@dataclass(frozen=True)
class Question:
    """The question put to every recording.

    model : compared with the recording; with `fitted_base` its hard and soft iron are unknown and fitted.
    field_enu_nT, strength_nT : the stated reference; None: the model's field, else the reference of the source.
    actuators : channels treated like motor currents. policy : the numbers that decide.
    """

    model: Model = field(default_factory=ModelSpec)
    fitted_base: bool = False
    field_enu_nT: Sequence[float] | None = None
    strength_nT: float | None = None
    actuators: Sequence[str] = ()
    policy: Policy = STANDARD

    @classmethod
    def about(cls, model: str | Path | None, **stated: Any) -> Self:
        """The question about a scenario or model file; without one iron and white noise are fitted.

        Raises InputError for a model that cannot be used.
        """
        return cls(load_model(model) if model else ModelSpec(), model is None, **stated)

    def model_for(self, source: Source) -> Model:
        """The model of the source's sensor."""
        return model_of_sensor(self.model, source.sensor)

    def recording(self, source: Source) -> Recording:
        """The recording of one sensor, with its reference sensor and actuators; InputError for bad files and names."""
        whole = one_sensor(source.read().in_nT(str(source.place)), source.sensor, source.reference_sensor, source.place)
        kept = {name: x for name, x in whole.channels.items() if may_be_cause(name) or name in self.actuators}
        return with_actuators(replace(whole, channels=kept), self.actuators, source.place)

    def known_field(self, source: Source, recording: Recording) -> Field:
        """The reference of a recording; both None where the model or a second magnetometer gives the field."""
        stated = self.field_enu_nT is not None or self.strength_nT is not None
        if not needs_field(recording, self.model_for(source), stated=stated):
            return None, None
        known = source.reference(
            *told_field(self.strength_nT, self.field_enu_nT, recording.origin, recording.mag_nT), BY_MODEL
        )
        return None if known.field_enu_nT is None else np.array(known.field_enu_nT), known.strength_nT

    def posed(self, source: Source, recording: Recording, known: Field) -> LinearProblem:
        """The linear problem of a recording with its known field; InputError where model and recording do not fit."""
        model = self.model_for(source)
        return pose_model(recording, model, *known, iron_known=not self.fitted_base, policy=self.policy)

    def problem(self, source: Source) -> LinearProblem:
        """The linear problem of a source; error messages about the recording begin with the source's name."""
        recording = self.recording(source)
        with errors_relocated(source.name, "recording"):
            return self.posed(source, recording, self.known_field(source, recording))
