"""The question of a diagnosis, of model, known field and channels of motors, and its answer."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any, Self

import numpy as np

from calib.numerics.threads import one_thread
from diagnosis.next_leg.advice import advised
from diagnosis.policy import STANDARD, Policy
from diagnosis.problem.formulation import pose_model
from diagnosis.problem.linear import LinearProblem
from diagnosis.problem.sensors import BY_MODEL, model_of_sensor, needs_field, one_sensor, with_actuators
from diagnosis.result import Diagnosis
from diagnosis.several.confirmation import confirmed
from diagnosis.several.result import PooledDiagnosis
from diagnosis.several.workflow import check_apart, diagnose_sensors, diagnose_together
from diagnosis.sources import Source, of_one_array
from diagnosis.workflow import Progress, diagnosis_of, examine
from recordings import Recording
from recordings.channels import may_be_cause
from scenarios.arrays import Array
from scenarios.errors import errors_relocated
from sim.pool import Tasks
from sim.scenario import Model, ModelSpec, load_model
from validation.calibrating.reference import told_field

CONFIRM = "--confirm"
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


@one_thread()
def answer(
    question: Question,
    sources: Sequence[Source],
    confirm: Source | None = None,
    say: Progress = lambda what: None,
    cluster: Tasks | None = None,
) -> Diagnosis | PooledDiagnosis:
    """Diagnose the sources: a single recording, several recordings together, or the sensors of an array.

    confirm : a second recording, in which the causes found in a single recording must hold too.
    say : called with each stage. cluster : examines several recordings, each a task.
    Raises InputError for files, columns, models and references that cannot be used.
    """
    if len(sources) == 1:
        return _answer_single(question, sources[0], confirm, say)
    problems = []
    for source in sources:
        recording = question.recording(source)
        with errors_relocated(source.name, "recording"):
            problems.append(question.posed(source, recording, question.known_field(source, recording)))
    names, models = [source.name for source in sources], [question.model_for(source) for source in sources]
    if of_one_array(sources):
        return diagnose_sensors(names, problems, models, say=say)
    return diagnose_together(names, problems, models[0], cluster=cluster, say=say)


def _answer_single(question: Question, source: Source, confirm: Source | None, say: Progress) -> Diagnosis:
    say("direct evidence")
    model, recording = question.model_for(source), question.recording(source)
    second = None if confirm is None else question.recording(confirm)
    if second is not None:
        check_apart(recording, second, CONFIRM)
    known = question.known_field(source, recording)
    seen = examine(question.posed(source, recording, known), model, say=say)
    say("the simulator with the new model")
    found = diagnosis_of(seen)
    if second is not None:
        say("the second recording")
        with errors_relocated(CONFIRM, "recording"):
            found = confirmed(found, second, model, *known)
    say("what to fly next")
    return advised(found)
