"""Cross-validation of soft iron, eddy currents and temperature on a recording."""

from __future__ import annotations

from dataclasses import dataclass

from calib import Reference, get
from calib.held_out.legs import LegPartition, legs_of
from calib.held_out.models import Model, offset, with_iron
from calib.held_out.paired_legs import HeldOutErrors, ModelPair
from recordings import Recording
from scenarios.errors import InputError
from validation.calibrating.fitting import sensor_recordings
from validation.cross_validation.extensions import extensions
from validation.signals.thinning import every_nth

LEAST_SAMPLES = 24
"""Least number of samples: twice the parameters of the full matrix and offset."""
UNDETERMINED = "this motion does not determine the offset"
MOST_SAMPLES = 10_000
"""Samples at most; longer recordings are thinned, since the residual of models depends on the motion."""


@dataclass(frozen=True, eq=False)
class CrossValidation:
    """Pairs of simpler and richer models: first offset and matrix, then extensions of the better.

    keep : name of the recommended model, "" if the motion does not determine the offset
    """

    sensor: str
    knowledge: str
    legs: LegPartition
    pairs: tuple[ModelPair, ...]
    keep: str


def cross_validate(recording: Recording, reference: Reference) -> tuple[CrossValidation, ...]:
    """Cross-validate the models of each sensor; InputError for a recording that is too short."""
    if len(recording) < LEAST_SAMPLES:
        what = f"{len(recording)} samples are too few to hold some out"
        raise InputError(what, where="--worth", do=f"record {LEAST_SAMPLES} or more")
    thinned = recording.taken(every_nth(len(recording), MOST_SAMPLES))
    return tuple(_of_sensor(key, one, reference) for key, one in sensor_recordings(thinned, "sensor").items())


def _of_sensor(sensor: str, recording: Recording, reference: Reference) -> CrossValidation:
    """Cross-validate a sensor: by vectors with attitude and field vector, else by the strength.

    Wild samples are left out, as from an ellipsoid. Soft iron is tested again after accepted extensions, since a
    missing extension can pass for soft iron.
    """
    recording = get("ellipsoid").fit(recording, reference).used(recording)
    legs, strength_nT, simple = legs_of(recording), reference.strength_nT, offset(recording, reference)
    pair, doubt = (simple, with_iron(simple)), _doubt(simple, recording, reference)
    found = [_paired(pair, doubt, legs, strength_nT)]
    now = found[0].kept
    for extra in extensions(recording):
        found.append(extra.pair(now, legs, strength_nT))
        if found[-1].kept is not now:
            now, pair = found[-1].kept, (extra.add(pair[0]), extra.add(pair[1]))
    if pair[0] is not simple:
        found.append(_paired(pair, doubt, legs, strength_nT))
        now = found[-1].kept
    return CrossValidation(
        sensor,
        "strength" if simple.known is None else "vector",
        legs,
        tuple(found),
        _kept(now.model, recording, reference),
    )


def _paired(models: tuple[Model, Model], doubt: str, legs: LegPartition, strength_nT: float) -> ModelPair:
    simpler, richer = (HeldOutErrors.of(one, legs, strength_nT) for one in models)
    return ModelPair(simpler, richer, doubt)


def _doubt(simple: Model, recording: Recording, reference: Reference) -> str:
    """Return a reason against soft iron: the motion is too small for a calibrator with soft iron."""
    method = get("ellipsoid" if simple.known is None else "vector_least_squares")
    return UNDETERMINED if method.fit(recording, reference).status.kind == "unobservable" else ""


def _kept(model: Model, recording: Recording, reference: Reference) -> str:
    """Return the model's name, "" for an offset that the sphere calibrator finds unobservable."""
    alone = model.known is None and len(model.slots) == 1
    lost = alone and get("sphere").fit(recording, reference).status.kind == "unobservable"
    return "" if lost else model.name
