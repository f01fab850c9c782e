"""Whether soft iron, eddy currents and temperature are worth their parameters on a recording."""

from __future__ import annotations

from dataclasses import dataclass

from calib import Reference, get
from scenarios.errors import InputError
from sim.dataset import Recording
from validation.calibrating.fitting import sensors
from validation.signals.thin import every_nth
from validation.worth.legs import Legs, legs_of
from validation.worth.models import Model, offset, with_eddy, with_iron
from validation.worth.paired import Pair, Unseen
from validation.worth.slow import with_temperature

LEAST_SAMPLES = 24
"""Twice the parameters of the larger base: fewer leave nothing to hold out."""
UNTOLD = "this motion does not tell its offset"
MOST_SAMPLES = 10_000
"""Of a longer recording every second, third, ... sample is taken: what the models leave hangs on the motion."""


@dataclass(frozen=True, eq=False)
class Worth:
    """Pairs of a simpler and a richer model: offset and matrix first, then what is added to the better of them."""

    sensor: str
    knowledge: str
    legs: Legs
    pairs: tuple[Pair, ...]


def worth(recording: Recording, reference: Reference) -> tuple[Worth, ...]:
    """Which models predict unseen legs better, of each sensor; InputError for a recording that is too short."""
    if len(recording) < LEAST_SAMPLES:
        what = f"{len(recording)} samples are too few to hold some of them out"
        raise InputError(what, where="--worth", do=f"record {LEAST_SAMPLES} or more")
    thinned = recording.taken(every_nth(len(recording), MOST_SAMPLES))
    return tuple(_of_sensor(key, one, reference) for key, one in sensors(thinned, "sensor").items())


def _of_sensor(sensor: str, recording: Recording, reference: Reference) -> Worth:
    """With attitude and the field's vector all of the misfit counts, else the distance that the strength tells."""
    legs, strength_nT = legs_of(recording), reference.strength_nT
    simple = offset(recording, reference)
    plain = Unseen.of(simple, legs, strength_nT)
    found = [Pair(plain, Unseen.of(with_iron(simple), legs, strength_nT), _doubt(simple, recording, reference))]
    base = found[0].richer if found[0].verdict == "worth_it" else plain
    eddy = with_eddy(base.model, recording)
    if eddy is not None:
        found.append(Pair(base, Unseen.of(eddy, legs, strength_nT)))
    warm = with_temperature(base, recording, legs, strength_nT)
    if warm is not None:
        found.append(warm)
    return Worth(sensor, "strength" if simple.known is None else "vector", legs, tuple(found))


def _doubt(simple: Model, recording: Recording, reference: Reference) -> str:
    """Why soft iron is not to be taken though it predicts better: a calibrator of it finds the motion too little."""
    method = get("ellipsoid" if simple.known is None else "vector_least_squares")
    return UNTOLD if method.fit(recording, reference).status.kind == "unobservable" else ""
