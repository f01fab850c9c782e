"""The conversion between named columns and the types Recording and Truth."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from recordings.channels import HEIGHT
from recordings.columns import (
    POSITION,
    SIGNAL,
    SIGNALS,
    TRUE_ATTITUDE,
    TRUE_FIELD,
    TRUE_POSITION,
    Signal,
    effect_names,
    group_of,
    labelled_effects,
    mag_names,
    numbers,
)
from recordings.recording import STATED, Origin, Recording, Truth
from scenarios.arrays import Array

Named = Mapping[str, NDArray[Any]]


def recording_of(named: Named, origin: Origin = STATED) -> Recording:
    """Return the recording in named columns, without truth; a vector that lacks a component is None."""
    held: dict[str, Any] = {signal.field: _signal(named, signal) for signal in SIGNALS if signal.group != "mag"}
    held["channels"] = _channels(named)
    held["motor_numbers"] = numbers("current", tuple(named))
    sensors = numbers("mag", tuple(named))
    array = np.stack([_stack(named, mag_names(k)) for k in sensors]) if sensors else None
    mag_nT = _stack(named, mag_names()) if array is None else array[0]
    return Recording(**held, mag_nT=mag_nT, array_mag_nT=array, origin=origin)


def truth_of(named: Named, parameters: dict[str, Any]) -> Truth:
    """Return the truth in named columns, which `checks.check_truth` has found complete."""
    sensors = numbers("mag", tuple(named))
    effects = {
        effect: np.stack([_stack(named, effect_names(effect, k)) for k in sensors])
        if sensors
        else _stack(named, effect_names(effect))
        for effect in labelled_effects(tuple(named))
    }
    return Truth(
        field_nT=_stack(named, TRUE_FIELD),
        q=_stack(named, TRUE_ATTITUDE),
        pos_enu_m=_stack(named, TRUE_POSITION),
        effects=effects,
        parameters=parameters,
    )


def arrays_of(recording: Recording) -> dict[str, NDArray[Any]]:
    """Return the columns that a recording fills: the inverse of `recording_of`."""
    array = recording.array_mag_nT
    sensors: dict[int | None, Array] = {None: recording.mag_nT} if array is None else dict(enumerate(array, start=1))
    named: dict[str, NDArray[Any]] = {}
    for signal in SIGNALS:
        values = getattr(recording, signal.field)
        if signal.group == "mag":
            for number, field_nT in sensors.items():
                named |= _split(mag_names(number), field_nT)
        elif values is not None:
            named |= _split(_names(signal, recording), values)
    return named | recording.channels


def scalars_of(recording: Recording) -> dict[str, Array]:
    """Return what effects may depend on, each (n,): temperature, motor currents, height and all channels."""
    held = ((SIGNAL[group], getattr(recording, SIGNAL[group].field)) for group in ("temperature", "current"))
    named: dict[str, Array] = {}
    for signal, values in held:
        named |= {} if values is None else _split(_names(signal, recording), values)
    if recording.pos_enu_m is not None:
        named[HEIGHT] = recording.pos_enu_m[:, 2]
    return named | recording.channels


def _stack(named: Named, names: Sequence[str]) -> Array:
    return np.column_stack([named[name] for name in names])


def _signal(named: Named, signal: Signal) -> NDArray[Any] | None:
    """Return a signal as the recording keeps it: (n,) for one column, (n, m) for several; None if one is missing."""
    if signal.number:
        names = [name for k in numbers(signal.group, tuple(named)) for name in signal.names(k)]
        return _stack(named, names) if names else None
    if not all(name in named for name in signal.columns):
        return None
    return named[signal.columns[0]] if len(signal.columns) == 1 else _stack(named, signal.columns)


def _names(signal: Signal, recording: Recording) -> list[str]:
    """Return the columns that a signal fills: of the current, one a motor; not for the magnetometer."""
    if signal.number:
        return [name for motor in recording.motors for name in signal.names(motor)]
    return list(signal.columns)


def _channels(named: Named) -> dict[str, Array]:
    """Return the columns in no table, and the components of an incomplete position, such as the depth alone."""
    partial = () if all(name in named for name in POSITION) else POSITION
    return {name: values for name, values in named.items() if group_of(name) == "channel" or name in partial}


def _split(names: Sequence[str], values: NDArray[Any]) -> dict[str, NDArray[Any]]:
    return dict(zip(names, [values] if values.ndim == 1 else values.T, strict=True))
