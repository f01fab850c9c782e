"""Between named columns and the types Recording and Truth."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from sim.dataset.columns import (
    ACCEL,
    ATTITUDE,
    GYRO,
    POSITION,
    TRUE_ATTITUDE,
    TRUE_FIELD,
    TRUE_POSITION,
    effect_names,
    effects_among,
    group_of,
    mag_names,
    numbers,
)
from sim.dataset.recording import Array, Recording, Truth

Named = Mapping[str, NDArray[Any]]


def recording_of(named: Named) -> Recording:
    """The recording in named columns; truth is left out, a vector with a missing component is None."""
    sensors = numbers("mag", tuple(named))
    array = np.stack([_stack(named, mag_names(k)) for k in sensors]) if sensors else None
    motors = tuple(f"current_{i}_A" for i in numbers("current", tuple(named)))
    return Recording(
        time_s=named["time_s"],
        mag_nT=_stack(named, mag_names()) if array is None else array[0],
        gyro_rad_s=_optional(named, GYRO),
        accel_m_s2=_optional(named, ACCEL),
        att_q=_optional(named, ATTITUDE),
        pos_enu_m=_optional(named, POSITION),
        temperature_degC=named.get("temperature_degC"),
        current_A=_stack(named, motors) if motors else None,
        phase=named.get("phase"),
        channels=_channels(named),
        array_mag_nT=array,
    )


def truth_of(named: Named, parameters: dict[str, Any]) -> Truth:
    """The truth in named columns, see `checks.whole_truth`."""
    sensors = numbers("mag", tuple(named))
    effects = {
        effect: np.stack([_stack(named, effect_names(effect, k)) for k in sensors])
        if sensors
        else _stack(named, effect_names(effect))
        for effect in effects_among(tuple(named))
    }
    return Truth(
        field_nT=_stack(named, TRUE_FIELD),
        q=_stack(named, TRUE_ATTITUDE),
        pos_enu_m=_stack(named, TRUE_POSITION),
        effects=effects,
        parameters=parameters,
    )


def arrays_of(recording: Recording) -> dict[str, NDArray[Any]]:
    """The inverse of `recording_of`: the columns that a recording fills."""
    named: dict[str, NDArray[Any]] = {"time_s": recording.time_s}
    if recording.array_mag_nT is None:
        named |= _split(mag_names(), recording.mag_nT)
    else:
        for k, field_nT in enumerate(recording.array_mag_nT, start=1):
            named |= _split(mag_names(k), field_nT)
    named |= _split(GYRO, recording.gyro_rad_s) | _split(ACCEL, recording.accel_m_s2)
    named |= _split(ATTITUDE, recording.att_q) | _split(POSITION, recording.pos_enu_m)
    if recording.temperature_degC is not None:
        named["temperature_degC"] = recording.temperature_degC
    if recording.current_A is not None:
        motors = range(1, recording.current_A.shape[1] + 1)
        named |= _split([f"current_{i}_A" for i in motors], recording.current_A)
    if recording.phase is not None:
        named["phase"] = recording.phase
    return named | recording.channels


def _stack(named: Named, names: Sequence[str]) -> Array:
    return np.column_stack([named[name] for name in names])


def _optional(named: Named, names: Sequence[str]) -> Array | None:
    return _stack(named, names) if all(name in named for name in names) else None


def _channels(named: Named) -> dict[str, Array]:
    """Columns in no table; and a position that is not whole, such as the depth alone."""
    partial = () if all(name in named for name in POSITION) else POSITION
    return {name: values for name, values in named.items() if group_of(name) == "channel" or name in partial}


def _split(names: Sequence[str], values: NDArray[Any] | None) -> dict[str, NDArray[Any]]:
    return {} if values is None else dict(zip(names, values.T, strict=True))
