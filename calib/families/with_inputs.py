"""Calibrators with terms of recorded inputs: iron, motor currents or commands, temperature, eddy currents."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import ClassVar, Literal

import numpy as np

from calib.acceptance import MAX_MISFIT_FRACTION
from calib.base import Calibrator
from calib.held_out.input_models import InputModels, eddy_entries, least_squares_covariance
from calib.held_out.input_words import caveat, missing_excitation
from calib.held_out.models import Model
from calib.held_out.selection import InputChoice, selected
from calib.input_terms import InputTerm
from calib.models.ellipsoid import SYMMETRIC_NAMES, Ellipsoid, Standardised
from calib.models.inputs import InputGroup, input_groups
from calib.models.quadric import fit_ellipsoid_specific, refit
from calib.models.vector import EDDY_NAMES, SOFT_IRON_NAMES
from calib.observability import Extent, unobservable
from calib.reference import Reference
from calib.result import OFFSET_NAMES, Calibration, Status
from recordings import Recording
from scenarios.arrays import Array

MOST_SAMPLES = 5_000
"""Samples, evenly spaced, that inputs are chosen by; the chosen model is fitted to all."""
HELD_OUT, HELD_OUT_WITHOUT = "held_out_rms_nT", "held_out_rms_without_inputs_nT"
"""Parameters: rms on legs that no fit has seen, with and without the terms of inputs."""

NO_ELLIPSOID = "no ellipsoid fits the measurements: check field, unit and axes, or turn about more axes"


@dataclass(frozen=True)
class CalibratorWithInputs(Calibrator):
    """m = S h + b + sum_j k_j (p_j - p_j0) + B dh/dt, the terms of p and B where unseen legs bear them out.

    inputs : what may be used: the battery's current (or the sum of the motors'), each motor's, the throttle, each
        motor's output; any of these, or none. temperature, turning : whether an offset proportional to the temperature,
        and eddy currents, may be used. lags : whether the field may follow an input by a first-order lag.
    """

    inputs: Literal["any", "battery", "motors", "throttle", "outputs", "none"] = "any"
    temperature: bool = True
    turning: bool = True
    lags: bool = True
    min_samples: ClassVar[int] = 60

    def _solve(self, recording: Recording, reference: Reference, rng: np.random.Generator) -> Calibration | Status:
        groups = input_groups(recording, self._kinds)
        reference = reference if self._fits_vector else Reference(reference.strength_nT)
        part = slice(None, None, max(1, -(-len(recording) // MOST_SAMPLES)))
        models = InputModels.of(recording, reference, part, eddy=self.turning)
        choice = selected(models, groups, lags=self.lags and recording.origin.timed)
        whole = InputModels.of(recording, reference, slice(None), eddy=choice.eddy)
        fitted = whole.model(choice.groups, eddy=choice.eddy)
        found = fitted_calibration(self.name, fitted, choice, reference.strength_nT)
        if found.parameters["noise_std_nT"] > MAX_MISFIT_FRACTION * reference.strength_nT and not self._fits_vector:
            return _unfitted(recording)
        without = choice.errors if not choice.groups else models.errors(models.model((), eddy=choice.eddy))
        rms = {HELD_OUT: choice.errors.typical_nT, HELD_OUT_WITHOUT: without.typical_nT}
        status = self._status(models, choice, groups)
        return replace(found, status=status, parameters=found.parameters | rms)

    @property
    def _kinds(self) -> set[str]:
        """The kinds of inputs that the settings permit."""
        power = {"battery", "motors", "throttle", "outputs"} if self.inputs == "any" else {self.inputs}
        return power | ({"temperature"} if self.temperature else set())

    def _status(self, models: InputModels, choice: InputChoice, groups: Sequence[InputGroup]) -> Status:
        """Ok, possibly with a caveat; unobservable where no current or command is excited enough to be told."""
        lost = missing_excitation(models, choice, groups)
        return Status("unobservable", lost) if lost else Status("ok", caveat(models, choice, groups))


def _unfitted(recording: Recording) -> Status:
    """Why no ellipsoid fits: unobservable where the best quadric through the measurements is none."""
    x = Standardised.of(recording.mag_nT).x
    if Ellipsoid.of_quadric(refit(x, fit_ellipsoid_specific(x)).theta) is not None:
        return Status("not_converged", NO_ELLIPSOID)
    why = "the quadric that fits the measurements best is not an ellipsoid"
    return unobservable(Extent.of(recording.mag_nT).thinnest, why)


def fitted_calibration(name: str, model: Model, choice: InputChoice, strength_nT: float) -> Calibration:
    """The calibration of a fitted model, in nT, with the covariance of least squares."""
    to_named, names = _named(model, choice, strength_nT)
    values = to_named @ model.found
    variance, covariance = least_squares_covariance(model)
    lags = {f"{one.channels[0]}_lag_s": one.lag_s for one in choice.groups if one.lag_s}
    noise = {"noise_std_nT": strength_nT * float(np.sqrt(variance))}
    entries = model.found[3 : 3 + len(model.slots)]
    return Calibration(
        name=name,
        status=Status("ok"),
        offset_nT=strength_nT * model.found[:3],
        matrix=np.asarray(np.linalg.inv(np.tensordot(entries, model.slots, 1))),
        eddy_s=values[-9:].reshape(3, 3) if choice.eddy else None,
        parameters=dict(zip(names, values.tolist(), strict=True)) | lags | noise,
        covariance=to_named @ covariance @ to_named.T,
        covariance_names=names,
        inputs=_terms(model, choice, strength_nT),
    )


def _named(model: Model, choice: InputChoice, strength_nT: float) -> tuple[Array, tuple[str, ...]]:
    """Matrix from a model's parameters to named ones in nT, 1 and s, and the names."""
    soft = SYMMETRIC_NAMES if model.known is None else SOFT_IRON_NAMES
    gains = tuple(
        name for one in choice.groups for term in one.terms(np.zeros((len(one.channels), 3))) for name in term.names
    )
    units = np.array([strength_nT] * 3 + [1.0] * len(soft) + [strength_nT] * len(gains))
    if not choice.eddy:
        return np.diag(units), (*OFFSET_NAMES, *soft, *gains)
    entries = eddy_entries(model)
    out = np.zeros((len(units) + 9, model.count))
    out[: len(units), : len(units)] = np.diag(units)
    out[len(units) :, len(units) :] = entries.T
    return out, (*OFFSET_NAMES, *soft, *gains, *EDDY_NAMES)


def _terms(model: Model, choice: InputChoice, strength_nT: float) -> tuple[InputTerm, ...]:
    """The terms of all groups, with gains in nT."""
    at, terms = 3 + len(model.slots), list[InputTerm]()
    for group in choice.groups:
        count = len(group.channels)
        gains = strength_nT * model.found[at : at + 3 * count].reshape(count, 3)
        terms += group.terms(gains)
        at += 3 * count
    return tuple(terms)
