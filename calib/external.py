"""External calibrators: permitted objects, call, and checks of the result."""

from __future__ import annotations

import json
import time
from collections.abc import Callable, Iterable, Mapping
from dataclasses import replace
from typing import Any

import numpy as np

from calib.base import NEEDS, Calibrator, read_only, unusable
from calib.reference import Reference
from calib.result import Calibration
from calib.serial import from_json, to_dict
from recordings import Recording
from scenarios.errors import InputError

Function = Callable[[Recording, Reference], object]
ExternalMethod = Calibrator | Function
"""A calibrator, or a function (recording, reference) with a result for `calibration_of`."""
WANTED = "return (offset_nT, matrix), a dict with keys of calibration.json, or a Calibration"
MAX_CONDITION, MAX_OFFSET_NT = 1e6, 1e9
"""Limits of the matrix's condition and of the offset (a tesla), far beyond any magnetometer's calibration."""


def external_method(found: object, where: str) -> ExternalMethod:
    """A Calibrator (instance, or subclass with default settings) or a function; InputError for any other object."""
    if isinstance(found, type) and issubclass(found, Calibrator):
        try:
            return found()
        except TypeError as error:
            raise InputError(f"cannot be made: {error}", where=where, do="name an instance of it") from None
    if not isinstance(found, Calibrator) and (isinstance(found, type) or not callable(found)):
        what = f"is of type {type(found).__name__}, no calibrator"
        raise InputError(what, where=where, do="name a Calibrator, or a function of (recording, reference)")
    needs_of(found, where)
    return found


def needs_of(method: ExternalMethod, where: str) -> tuple[str, ...]:
    """Inputs needed by a method, keys of NEEDS; a function without `needs` takes the field's strength alone."""
    needs = getattr(method, "needs", ())
    if isinstance(needs, str) or not isinstance(needs, Iterable) or not set(needs) <= NEEDS.keys():
        raise InputError(f"needs {needs!r}", where=where, do=f"a tuple of some of {', '.join(NEEDS)}")
    return tuple(needs)


def fit_external(
    method: ExternalMethod, recording: Recording, reference: Reference, rng: np.random.Generator, name: str
) -> Calibration:
    """The method's own result under a name, without checks of covariance and status; exceptions of the method pass.

    Raises InputError for a result in none of the forms of `calibration_of`.
    """
    start_s = time.perf_counter()
    if isinstance(method, Calibrator):
        found = calibration_of(method.fit_unchecked(recording, reference, rng), name)
    else:
        status = unusable(recording, reference, needs_of(method, name), name)
        if status is not None:
            return Calibration(name=name, status=status)
        found = calibration_of(method(read_only(recording), reference), name)
    return replace(found, name=name, wall_s=time.perf_counter() - start_s)


def calibration_of(answer: object, where: str) -> Calibration:
    """The calibration returned by a function: (offset_nT, matrix), a dict with keys of the JSON, or a Calibration.

    Raises InputError for anything else, and as `checked`.
    """
    if isinstance(answer, Calibration):
        answer = to_dict(answer)
    elif isinstance(answer, tuple | list) and len(answer) == 2:
        answer = dict(zip(("offset_nT", "matrix"), answer, strict=True))
    if not isinstance(answer, Mapping):
        raise InputError(f"answered with {type(answer).__name__}", where=where, do=WANTED)
    try:
        text = json.dumps(dict(answer), default=_plain)
    except (TypeError, ValueError) as error:
        raise InputError(f"answered with what JSON cannot hold: {error}", where=where, do=WANTED) from None
    return checked(from_json(text, where=where), where)


def checked(calibration: Calibration, where: str, do: str = "") -> Calibration:
    """The calibration unchanged; InputError for a singular matrix and for an offset of a tesla."""
    matrices = np.stack([calibration.matrix, *(part.matrix for part in calibration.segments)])
    offsets_nT = np.stack([calibration.offset_nT, *(part.offset_nT for part in calibration.segments)])
    if not (np.isfinite(matrices).all() and np.isfinite(offsets_nT).all()):
        raise InputError("is no calibration: not all its values are finite", where=where, do=do)
    with np.errstate(all="ignore"):  # a condition that is not finite is too large, too
        condition = np.linalg.cond(matrices).max()
    if not condition <= MAX_CONDITION:
        raise InputError("is no calibration: its matrix is singular", where=where, do=do)
    if np.abs(offsets_nT).max() > MAX_OFFSET_NT:
        raise InputError("is no calibration: its offset is a tesla", where=where, do=do)
    return calibration


def _plain(value: Any) -> Any:
    """The plain values of a numpy array or scalar."""
    if isinstance(value, np.ndarray | np.generic):
        return value.tolist()
    raise TypeError(f"{type(value).__name__} is no number, list or text")
