"""What the gradiometer calibrators share: checks, polish, covariance, and the calibration of the whole array."""

from __future__ import annotations

import math
from abc import abstractmethod
from dataclasses import dataclass
from typing import ClassVar, final

import numpy as np
import scipy.optimize

from calib.base import Calibrator
from calib.models.array_spread import Spread
from calib.models.sensor_array import (
    SENSOR_NAMES,
    ArrayObjective,
    array_objective,
    free_parameters,
    maps,
    parameter_units,
    residual_size,
    residuals,
)
from calib.observability import MAX_STD_FRACTION, rounded_sizes
from calib.reference import Reference
from calib.result import Calibration, Status
from calib.settings import NotNegative
from recordings import Recording
from scenarios.arrays import Array
from scenarios.text import figure

MAX_NOISE_FRACTION = 0.005
"""A residual noise above this fraction of the field is not noise: the search ended in a wrong place."""


OK = Status("ok")


@dataclass(frozen=True, eq=False)
class ArrayEstimate:
    """Where a search ended: parameters (12 k,), the rms of its objective in nT after each round, and how it ended."""

    parameters: Array
    history: tuple[float, ...] = ()
    status: Status = OK


@dataclass(frozen=True)
class GradiometerCalibrator(Calibrator):
    """All sensors of an array at once, twelve parameters each, from the field's strength; a subclass writes `search`.

    h = T_gamma T_alpha T_beta (K C)^-1 (m - b) for every sensor, h the same for all of them [Ding2021] eq. 6, 16

    `components`, `tensor`, `invariants`: weights of the objective's terms (`array_objective`). `polish`: finish
    with Levenberg-Marquardt on the same objective. Covariance: linearised at the solution for white noise, equal on all
    axes, whose deviation comes from the residual. Result: in the frame of sensor 1, whose matrix K and C make
    triangular, since the strength tells no turn of the whole array.
    """

    needs: ClassVar[tuple[str, ...]] = ("array",)
    min_samples: ClassVar[int] = 20
    whole_array: ClassVar[bool] = True
    triangular: ClassVar[bool] = True
    components: NotNegative = 1.0
    tensor: NotNegative = 1.0
    invariants: NotNegative = 0.0
    polish: bool = True

    @abstractmethod
    def search(
        self, task: ArrayObjective, recording: Recording, reference: Reference, rng: np.random.Generator
    ) -> ArrayEstimate:
        """The method itself."""

    @final
    def _solve(self, recording: Recording, reference: Reference, rng: np.random.Generator) -> Calibration | Status:
        array_nT, strength_nT = recording.array_mag_nT, reference.strength_nT
        assert array_nT is not None
        if len(array_nT) < 2:
            return Status("not_applicable", "an array of magnetometers is needed, the recording has one sensor")
        task = array_objective(array_nT, strength_nT, self.components, self.tensor, self.invariants)
        found = self.search(task, recording, reference, rng)
        if found.status.kind not in ("ok", "not_converged"):
            return Calibration(name=self.name, status=found.status, history=found.history)
        if self.polish:
            found = polished(task, found)
        return _calibration(self.name, task, found, array_nT, strength_nT)


def polished(task: ArrayObjective, start: ArrayEstimate) -> ArrayEstimate:
    """The minimum of the objective next to a start, by Levenberg-Marquardt, with the start's history."""
    free, p, out = free_parameters(len(task.total)), start.parameters.copy(), np.empty(residual_size(task))

    def fun(values: Array) -> Array:
        p[free] = values
        residuals(p, task, out)
        return out.copy()

    found = scipy.optimize.least_squares(
        fun, start.parameters[free], "3-point", method="lm", xtol=1e-14, ftol=1e-14, gtol=1e-15, max_nfev=200
    )
    p[free] = found.x
    status = Status.settled(
        found.status > 0, f"no minimum after {found.nfev} steps of Levenberg-Marquardt: record more attitudes"
    )
    return ArrayEstimate(p, start.history, status)


def _calibration(
    name: str, task: ArrayObjective, found: ArrayEstimate, array_nT: Array, strength_nT: float
) -> Calibration:
    k, p = len(array_nT), found.parameters
    matrix, _ = maps(p, k)
    spread = Spread.of(task, p)
    noise_nT = spread.noise * strength_nT
    units = parameter_units(k, strength_nT)
    names = parameter_names(k)
    parameters = dict(zip(names, (p * units).tolist(), strict=True)) | {
        "noise_std_nT": noise_nT,
        "objective_rms_nT": spread.rms * strength_nT,
    }
    free = free_parameters(k)
    covariance = None if spread.covariance is None else spread.covariance * np.outer(units[free], units[free])
    offset_nT = p.reshape(k, -1)[:, :3] * strength_nT
    free_names = tuple(names[i] for i in free)
    status = _far(noise_nT, strength_nT) or _loose(covariance, free_names, strength_nT) or found.status
    return Calibration(
        name=name,
        status=status,
        offset_nT=offset_nT[0],
        matrix=matrix[0],
        parameters=parameters,
        covariance=covariance,
        covariance_names=free_names if covariance is not None else (),
        history=found.history,
        array_offset_nT=offset_nT,
        array_matrix=matrix,
    )


def parameter_names(k: int) -> tuple[str, ...]:
    """Names of the 12 k parameters: sensor 1's as in SENSOR_NAMES, the others' followed by @sensor."""
    return tuple(name if i == 0 else f"{name}@{i + 1}" for i in range(k) for name in SENSOR_NAMES)


def _far(noise_nT: float, strength_nT: float) -> Status | None:
    """Not converged when what is left is too much to be noise."""
    if noise_nT <= MAX_NOISE_FRACTION * strength_nT:
        return None
    return Status(
        "not_converged",
        f"the sensors still disagree by {figure(noise_nT)} nT rms an axis: a local minimum, an "
        "error beyond the search's bounds, or a field that is not uniform",
    )


def _loose(covariance: Array | None, names: tuple[str, ...], strength_nT: float) -> Status | None:
    """Unobservable when a parameter of any sensor is less certain than MAX_STD_FRACTION of the field, or of 1."""
    remedy = "turn the array about all three axes, through larger angles"
    if covariance is None:
        return Status("unobservable", f"the array's parameters cannot be distinguished: {remedy}")
    unit = [
        strength_nT if name.startswith("offset") else 1.0 if name.startswith("scale") else math.degrees(1.0)
        for name in names
    ]
    std = np.sqrt(np.diag(covariance)) / unit
    worst = int(np.argmax(rounded_sizes(std)))
    if std[worst] <= MAX_STD_FRACTION:
        return None
    return Status(
        "unobservable", f"standard deviation of {names[worst]}: {figure(std[worst] * unit[worst], 2)}; {remedy}"
    )
