"""Parameters shared by several paths: the smooth run-in, and commanded roll and pitch."""

from __future__ import annotations

import numpy as np
from pydantic import Field

from scenarios.arrays import Array
from scenarios.paths.base import LEAST_RAMP_S, PhaseBase
from scenarios.paths.jet import Jet, sine, window


class RunIn(PhaseBase):
    """A phase with a smooth change of speed at the start, after which tracking is judged."""

    run_in_s: float = Field(
        20.0, ge=LEAST_RAMP_S, le=600, description="smooth ramp of the speed; tracking is judged after it"
    )

    @property
    def settle_s(self) -> float:
        return self.run_in_s


class Excited(RunIn):
    """Commanded roll and pitch in addition to the path: amplitude * window(t) * sin(2 pi t / period).

    A vehicle that tracks perfectly stays level and hardly excites the vertical axis; these angles make the error model
    observable. The window ramps over run_in_s at both ends. The vehicle must be able to tilt without moving away.
    """

    roll_amplitude_deg: float = Field(0.0, ge=0, le=80)
    roll_period_s: float = Field(31.0, ge=1, le=3600)
    pitch_amplitude_deg: float = Field(0.0, ge=0, le=80)
    pitch_period_s: float = Field(47.0, ge=1, le=3600)

    @property
    def tilted(self) -> bool:
        return self.roll_amplitude_deg > 0 or self.pitch_amplitude_deg > 0

    def pitch_roll(self, t_s: Array) -> tuple[Jet, Jet]:
        """Return the commanded pitch and roll, rad."""
        envelope = window(t_s, self.duration_s, self.run_in_s)
        pitch = sine(t_s, np.radians(self.pitch_amplitude_deg), self.pitch_period_s)
        roll = sine(t_s, np.radians(self.roll_amplitude_deg), self.roll_period_s)
        return envelope * pitch, envelope * roll
