"""The diagnosis of files: recording, model and reference read, actuators made currents, a second recording asked."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import partial
from pathlib import Path

import numpy as np

from calib import Reference
from diagnosis.next_leg.advice import advised
from diagnosis.policy import STANDARD, Policy
from diagnosis.problem.actuators import with_actuators
from diagnosis.problem.array_sensor import model_of_sensor, one_sensor
from diagnosis.problem.relative import BY_MODEL, needs_field
from diagnosis.result import Diagnosis
from diagnosis.several.confirmation import confirmed
from diagnosis.several.workflow import check_apart
from diagnosis.workflow import diagnose
from recordings import Recording, read_recording
from recordings.manifest import file_of
from scenarios.errors import errors_relocated
from sim.scenario import Model, ModelSpec, load_model
from validation.calibrating.reference import reference_of

CONFIRM = "--confirm"
"""What names the second recording."""


def diagnose_file(
    measured: Path,
    model: str | None,
    *,
    confirm: Path | None = None,
    enu: Sequence[float] | None = None,
    strength_nT: float | None = None,
    maps: Sequence[str] = (),
    actuators: Sequence[str] = (),
    run: int = 0,
    sensor: int | None = None,
    reference_sensor: int | None = None,
    policy: Policy = STANDARD,
    say: Callable[[str], object] = lambda what: None,
) -> Diagnosis:
    """Diagnose a file against a model file or scenario; without one against fitted iron and white noise.

    sensor : which of an array, counted from 1. reference_sensor : the one that it is compared with.
    Raises InputError for files, columns, models and references that cannot be used.
    """
    file = file_of(measured, run)

    def read(path: Path) -> Recording:
        recording = one_sensor(read_recording(path, run=run, maps=maps), sensor, reference_sensor, path)
        return with_actuators(recording, actuators, path)

    return diagnose_against(
        model,
        partial(read, file),
        partial(reference_of, file, strength_nT, enu, BY_MODEL),
        stated=enu is not None or strength_nT is not None,
        confirm=None if confirm is None else partial(read, confirm),
        sensor=sensor,
        policy=policy,
        say=say,
    )


def diagnose_against(
    model: str | Path | None,
    read: Callable[[], Recording],
    reference: Callable[[], Reference],
    *,
    stated: bool,
    confirm: Callable[[], Recording] | None = None,
    sensor: int | None = None,
    policy: Policy = STANDARD,
    say: Callable[[str], object] = lambda what: None,
) -> Diagnosis:
    """Diagnose what is read against a model file or scenario; without one against fitted iron and white noise.

    reference : asked where it is `stated`, and where the model names no field. confirm : a second recording.
    sensor : which of the model's sensors is meant, counted from 1.
    """
    spec = model_of_sensor(load_model(model) if model else ModelSpec(), sensor)
    recording, second = read(), None if confirm is None else confirm()
    known = reference() if needs_field(recording, spec, stated=stated) else None
    return diagnose_recording(recording, spec, known, confirm=second, fitted_base=model is None, policy=policy, say=say)


def diagnose_recording(
    recording: Recording,
    model: Model,
    reference: Reference | None = None,
    *,
    confirm: Recording | None = None,
    fitted_base: bool = False,
    policy: Policy = STANDARD,
    say: Callable[[str], object] = lambda what: None,
) -> Diagnosis:
    """Diagnose a recording, and ask a second one where it is given; see `workflow.diagnose`."""
    vector, strength = None, None
    if confirm is not None:
        check_apart(recording, confirm, CONFIRM)
    if reference is not None:
        vector = None if reference.field_enu_nT is None else np.array(reference.field_enu_nT)
        strength = reference.strength_nT
    found = diagnose(
        recording, model, field_enu_nT=vector, strength_nT=strength, fitted_base=fitted_base, policy=policy, say=say
    )
    if confirm is not None:
        say("the second recording")
        with errors_relocated(CONFIRM, "recording"):
            found = confirmed(found, confirm, model, vector, strength)
    say("what to fly next")
    return advised(found)
