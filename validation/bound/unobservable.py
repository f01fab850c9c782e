"""Weak directions of a motion in terms of the parameters: direction, cause and remedy."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.spatial.transform import Rotation

from calib.observability import MAX_STD_FRACTION, axis_text, main_axis, rounded_sizes
from scenarios.arrays import Array
from validation.bound.bound import Bound
from validation.bound.experiment import Experiment
from validation.text import figure

MAIN_PART = 0.25
"""Component over the largest from which a parameter is part of a direction."""
TILTS = {
    "rolled by {} degrees for half of the time": "x",
    "pitched by {} degrees for half of the time": "y",
    "rolled by {0} degrees for a third of the time, then pitched by {0}": "xy",
}
ANGLES_DEG = (5.0, 10.0, 20.0, 30.0, 45.0)
"""Tilts that are tried as a remedy, in ascending order."""


@dataclass(frozen=True)
class Weak:
    """Direction of the parameters that the motion hardly determines: parameters, cause, and remedy with the gain."""

    what: str
    why: str
    remedy: str


def weak_directions(known: Experiment, bound: Bound) -> tuple[Weak, ...]:
    """Return directions with a standard deviation above MAX_STD_FRACTION of the field, weakest first."""
    values, vectors = np.linalg.eigh(bound.information.matrix)
    found = [vector for value, vector in zip(values, vectors.T, strict=True) if not _determined(value, known)]
    if not found:
        return ()
    remedy = _remedy(known, bound)
    return tuple(Weak(_parameters(vector, bound), _why(vector, known), remedy) for vector in found)


def observable(known: Experiment, bound: Bound) -> bool:
    """Return whether the standard deviation of every direction is below MAX_STD_FRACTION of the field."""
    return _determined(float(np.linalg.eigvalsh(bound.information.matrix)[0]), known)


def _determined(information: float, known: Experiment) -> bool:
    return information * (MAX_STD_FRACTION * known.strength_nT) ** 2 >= 1.0


def _parameters(vector: Array, bound: Bound) -> str:
    """Return the parameters that trade against each other, largest first, of equal ones in the order of the names."""
    size = rounded_sizes(vector)
    main = [k for k in np.argsort(-size, kind="stable") if size[k] >= MAIN_PART]
    return " against ".join(bound.information.names[k] for k in main)


def _why(vector: Array, known: Experiment) -> str:
    """Return the range of angles of the field to the offset's part of a direction, in words."""
    axis = vector[:3] if np.linalg.norm(vector[:3]) > MAIN_PART else _thinnest(known)
    angle_deg = np.degrees(np.arccos(np.clip(known.directions @ (axis / np.linalg.norm(axis)), -1.0, 1.0)))
    low, high = np.sort(np.where(axis[main_axis(axis)] > 0, 1, -1) * (angle_deg - 90.0) + 90.0)[[0, -1]]
    return f"the field stays between {figure(low, 3)} and {figure(high, 3)} degrees from {axis_text(axis)}"


def _thinnest(known: Experiment) -> Array:
    return np.asarray(np.linalg.eigh(np.cov(known.directions.T))[1][:, 0])


def _remedy(known: Experiment, bound: Bound) -> str:
    """Return the smallest tilt with all directions observable; at equal angle the tilt with the largest gain."""
    for angle_deg in ANGLES_DEG:
        tried = {how.format(f"{angle_deg:g}"): _tilted(known, bound, axes, angle_deg) for how, axes in TILTS.items()}
        how = min(tried, key=lambda how: tried[how].offset_rms_nT)
        if observable(known, tried[how]):
            return f"the same motion with the body {how}: {_size(tried[how])} in place of {_size(bound)}"
    more = "which is not enough: fly longer, or give the method more knowledge of the field"
    return f"the same motion with the body {how}: {_size(tried[how])} in place of {_size(bound)}, {more}"


def _tilted(known: Experiment, bound: Bound, axes: str, angle_deg: float) -> Bound:
    """Return the bound for equal times level and tilted about each of the axes."""
    turns = (Rotation.from_euler(axis, angle_deg, degrees=True).as_matrix() for axis in axes)
    return bound.shared_with([Bound.of(known.turned(R), bound.knowledge) for R in turns])


def _size(bound: Bound) -> str:
    size = bound.offset_rms_nT
    return f"an offset error of {figure(size)} nT" if np.isfinite(size) else "an undetermined offset"
