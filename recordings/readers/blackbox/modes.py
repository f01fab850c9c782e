"""The flags of a blackbox log as names of flight modes."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
from numpy.typing import NDArray

from recordings.streams import Values

INAV = "INAV"
"""The firmware's name in the header."""
BETAFLIGHT_MODES = ("ARM", "ANGLE", "HORIZON")
"""Bits of `flightModeFlags`, the switches: the numbers of the first three are those of every release [boxId_e]."""
ARM = 1
"""The bit of arming among the switches."""
INAV_MODES = (
    *("ANGLE", "HORIZON", "HEADING", "ALTHOLD", "RTH", "POSHOLD", "HEADFREE", "LAUNCH", "MANUAL", "FAILSAFE"),
    *("AUTOTUNE", "WP", "COURSE HOLD", "FLAPERON", "TURN ASSISTANT", "TURTLE", "SOARING"),
)
"""Bits of `activeFlightModeFlags` [flightModeFlags_e]."""
ACRO = "ACRO"
"""The mode without any flag: rates alone are controlled."""


def phases_of(slow: Mapping[str, Values], inav: bool) -> NDArray[np.str_]:
    """Return the modes at each slow frame (n,), several joined by a plus; empty words without flags."""
    flags = slow.get("activeFlightModeFlags" if inav else "flightModeFlags")
    if flags is None:
        return np.full(len(next(iter(slow.values()), ())), "", np.str_)
    names = INAV_MODES if inav else BETAFLIGHT_MODES
    words = {int(one): _name(int(one), names) for one in np.unique(flags)}
    return np.array([words[one] for one in flags.tolist()], np.str_)


def _name(flags: int, names: tuple[str, ...]) -> str:
    found = [name for k, name in enumerate(names) if flags >> k & 1 and name != "ARM"]
    return "+".join(found) or ACRO
