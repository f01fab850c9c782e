"""From findings to one verdict, one sentence and what to do next."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from validation.diagnosis.evidence.battery import Battery
from validation.diagnosis.evidence.problem import Problem
from validation.diagnosis.library.candidates import ABSORBED
from validation.diagnosis.result import Gap, Named, Verdict, short

HALF = 0.5
_MOUNT = "turn the sensor in its mount, which turns its own errors and not the vehicle's"
_RATES = "turn and shake at several rates: a delay grows with the rate, a low-pass and eddy currents fall behind it"
_WARM = "let the temperature rise and fall again within one run"
_PLACE = "fly the track again at another height and heading"
_REST = "log a longer run at rest"
SPLIT = {
    "hard_iron": _MOUNT, "sensor_offset": _MOUNT, "soft_iron": _MOUNT, "scale": _MOUNT, "misalignment": _MOUNT,
    "non_orthogonality": _MOUNT, "latency": _RATES, "bandwidth": _RATES, "eddy_current": _RATES,
    "hysteresis": _RATES, "temperature_offset": _WARM, "temperature_scale": _WARM, "hard_iron_drift": _WARM,
    "local_dipole": _PLACE, "field_gradient": _PLACE, "attitude_misalignment": _PLACE,
    "diurnal_drift": "log a base station beside the run", "flicker_noise": _REST, "offset_random_walk": _REST,
    "offset_jump": _REST, "motor_current": "change the thrust while the attitude is held",
    "current_ripple": "change the thrust while the attitude is held",
    "nonlinearity": "turn the sensor about all axes, so that each sees the whole field",
}  # fmt: skip
"""What tells an effect from its look-alikes."""


def verdict_of(named: Sequence[Named], clean: bool, gap: Gap) -> Verdict:
    """The verdict: a name only where what is left is clean."""
    if not named:
        return "none" if clean else "unknown"
    if not clean:
        explained = gap.explained
        return "partial" if explained is None or explained >= HALF else "unknown"
    if all(one.how == "base" for one in named) and any(set(one.alternatives) - set(ABSORBED) for one in named):
        return "not_observable"
    if len(named) > 1:
        return "composite"
    if named[0].how == "spectrum":
        return "named" if not named[0].alternatives else "generic"
    return "class" if named[0].alternatives else "named"


def sentence_for(
    verdict: Verdict, named: Sequence[Named], gap: Gap, where: Sequence[tuple[str, str, float]], after: Battery
) -> str:
    """The finding in one sentence for a field engineer."""
    seen = gap.explained is not None and any(one.how == "held-out" for one in named)
    share = f", explaining {100 * (gap.explained or 0.0):.0f} % of the gap on held-out data" if seen else ""
    words = "; ".join(_words(one) for one in named)
    driver = f"; it goes with {', '.join(name for name, _, _ in where[:3])}" if where else ""
    left = "; ".join(after.why)
    return {
        "none": "The model agrees with the recording: what is left is no more than the noise that it states.",
        "named": f"Missing in the model: {words}{share}; what is left is clean.",
        "class": f"Missing in the model: {words}{share}; what is left is clean, but the data do not tell them apart.",
        "composite": f"Missing in the model: {words}{share}.",
        "partial": f"Missing in the model: {words}{share}, but something else is left ({left}).",
        "generic": f"A slow disturbance whose cause the data do not tell: {words}.",
        "unknown": f"Something is missing that no effect of the library explains ({left}){driver}.",
        "not_observable": f"Missing in the model: {words}; on this motion other effects look the same.",
    }[verdict]


def advice_for(
    verdict: Verdict,
    named: Sequence[Named],
    unseen: Sequence[str],
    missing: Sequence[str],
    problem: Problem,
    where: Sequence[tuple[str, str, float]],
    turning: bool,
) -> tuple[str, ...]:
    """What to do next: fly, log or check."""
    out: list[str] = []
    goes_with = [name for name, _, _ in where[:2] if name in problem.recording.channels]
    if goes_with and verdict not in ("none", "named", "class", "composite"):
        options = " ".join(f"--actuator {name}" for name in goes_with)
        out.append(f"The gap goes with {' and '.join(goes_with)}: try {options}.")
    if unseen:
        out.append(
            f"On this motion {', '.join(unseen)} can hardly be told from hard and soft iron, which they bias; "
            "fly turns at different rates and with changing roll and pitch (a spiral both ways, then a comb)."
        )
    for one in named:
        if one.alternatives:
            ways = dict.fromkeys(SPLIT[name] for name in (one.name, *one.alternatives) if name in SPLIT)
            out.append(f"{one.name} may also be {', '.join(one.alternatives)}. To tell: {'; '.join(ways)}.")
    if verdict in ("unknown", "partial") and turning:
        out.append("What is left has no part along the field: suspect navigation's attitude or time stamps.")
    if problem.mode == "strength":
        out.append("Without attitude only the field's strength was compared; log attitude to see more.")
    if named and all(one.evidence == "single-run" for one in named):
        out.append("Confirm on a second recording with --confirm: held-out segments of one run share its slow noise.")
    if missing:
        out.append("Not tested for want of channels: " + ", ".join(missing) + ".")
    return tuple(out)


def _words(one: Named) -> str:
    either = f" (or {', '.join(one.alternatives)})" if one.alternatives else ""
    size = "" if one.strength == 0 else f", {one.strength:.2g} sigma"
    main = (one.effect.linear or tuple(p.name for p in one.effect.parameters() if not p.options))[0]
    parameter = next(p for p in one.effect.parameters() if p.name == main)
    value = short(np.asarray(getattr(one.effect, main), dtype=float).tolist())
    return f"{one.name}{either}: {main} {value} {parameter.unit}".rstrip() + size
