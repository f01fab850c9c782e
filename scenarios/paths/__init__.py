"""Reference paths: a phase of the motion each, as a pure function of time."""

from __future__ import annotations

from typing import Annotated

from pydantic import Field

from scenarios.paths.base import REFERENCE_COLUMNS, Ability, PhaseBase, Start
from scenarios.paths.comb import Comb
from scenarios.paths.dive import Ascent, Descent
from scenarios.paths.hover import Hover, Rotate
from scenarios.paths.poses import Poses, Pushes
from scenarios.paths.spiral import Spiral
from scenarios.paths.turntable import Tumble, TurntableStops, TurntableTurns

PHASES: dict[str, type[PhaseBase]] = {
    "descent": Descent,
    "ascent": Ascent,
    "spiral": Spiral,
    "comb": Comb,
    "hover": Hover,
    "rotate": Rotate,
    "poses": Poses,
    "pushes": Pushes,
    "turntable_stops": TurntableStops,
    "turntable_turns": TurntableTurns,
    "tumble": Tumble,
}
"""Every kind of phase that a scenario file can name."""

Phase = Annotated[
    Descent | Ascent | Spiral | Comb | Hover | Rotate | Poses | Pushes | TurntableStops | TurntableTurns | Tumble,
    Field(discriminator="kind"),
]

__all__ = ["PHASES", "REFERENCE_COLUMNS", "Ability", "Phase", "PhaseBase", "Start"]
