"""Extensions of offset and matrix: eddy currents, and a temperature, compared with other slow signals."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import partial

from calib.held_out.legs import LegPartition
from calib.held_out.models import Model, with_eddy, with_temperature
from calib.held_out.paired_legs import HeldOutErrors, ModelPair
from calib.held_out.surrogates import DRIFT, surrogates
from calib.numerics.rates import body_rate
from recordings import Recording

Add = Callable[[Model], Model]
VARIES_DEGC = 1e-6
"""Rms change below which a temperature is not tried."""


@dataclass(frozen=True)
class Extension:
    """Extension of a model, with surrogate extensions that must all gain less."""

    add: Add
    rivals: tuple[Add, ...] = ()

    def pair(self, base: HeldOutErrors, legs: LegPartition, strength_nT: float) -> ModelPair:
        """Return the pair of models without and with the extension, on equal legs."""
        found = ModelPair(base, HeldOutErrors.of(self.add(base.model), legs, strength_nT))
        if found.verdict != "worth_it":
            return found
        others = (HeldOutErrors.of(rival(base.model), legs, strength_nT) for rival in self.rivals)
        same = any(one.typical_nT <= found.richer.typical_nT for one in others)
        return ModelPair(base, found.richer, DRIFT if same else "")


def extensions(recording: Recording) -> tuple[Extension, ...]:
    """Return eddy currents for a known body rate, and an offset by temperature for a recorded temperature."""
    rate_rad_s, temperature_degC = body_rate(recording), recording.temperature_degC
    found = [] if rate_rad_s is None else [Extension(partial(with_eddy, rate_rad_s=rate_rad_s))]
    if temperature_degC is not None and temperature_degC.std() > VARIES_DEGC:
        rivals = tuple(partial(with_temperature, temperature_degC=other) for other in surrogates(temperature_degC))
        found.append(Extension(partial(with_temperature, temperature_degC=temperature_degC), rivals))
    return tuple(found)
