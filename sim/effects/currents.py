"""Fields of currents in the vehicle: eddy currents in the skin, supply currents of the motors."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Annotated

import numpy as np

from recordings.channels import current_name
from scenarios.arrays import Array
from scenarios.errors import InputError
from sim.effects.base import ZERO3, ZERO33, Effect, Memory, array, frozen
from sim.effects.kernels import first_order_lag, kernel, times
from sim.effects.parameters import Mat3, Quantity, Vec3
from sim.effects.traits import AT_SEVERAL_RATES, LATE, OTHER_THRUST, Traits
from sim.state import State, missing_channel

Motor = Annotated[int, Quantity("", 0, 64, "which motor, from 1; 0: the sum of all", role="motor")]

BENT, LATE_CURRENT = "bent line", "late current"
DRIFT, SECOND, THIRD = "drift", "second harmonic", "third harmonic"
LAGS_S = (0.1, 0.3, 1.0, 3.0, 10.0, 30.0)


@frozen
class EddyCurrent(Effect):
    """Field of the eddy currents induced by turning in the Earth's field: ``B dT/dt`` ([Li2017] eq. 1).

    With a time constant tau, of a conductor with inductance, behind a first-order lag (exact for a rate linear between
    samples, steady at the start). Eddy currents oppose the change at most fully, so B <= tau: 0.5 s for a copper ball
    of half a metre, 0.2 s for an aluminium hull.
    """

    name = "eddy_current"
    stage = "vehicle"
    needs = ("rate",)
    example = {
        "matrix_s": ((0.1, 0.01, 0.02), (-0.03, 0.05, 0.03), (0.04, 0.01, 0.02)),
        "time_constant_s": 0.1,
    }
    traits = Traits(
        experiment=AT_SEVERAL_RATES, remedy="use a calibration with an eddy term, or turn more slowly", family=LATE
    )

    matrix_s: Annotated[
        Mat3, Quantity("s", -1.0, 1.0, "B, on the field's rate in the body frame (nT/s)", role="linear")
    ] = ZERO33
    time_constant_s: Annotated[
        float, Quantity("s", 0.0, 100.0, "lag of the currents; 0: none", role="listed", tried=(0.0, 0.1, 0.3, 1.0, 3.0))
    ] = 0.0

    def apply(self, state: State, signal_nT: Array, rng: np.random.Generator, memory: Memory) -> Array:
        drive = times(array(self.matrix_s), state.field_rate_nT_s)
        if self.time_constant_s > 0:
            return first_order_lag(drive, self.time_constant_s, state.interval_s, memory)
        return drive


@frozen
class MotorCurrent(Effect):
    """Field of the motors' supply currents: ``g I(t)``, with a bent line ``g I + g2 I |I| + g3 I^3``.

    Where the logged quantity leads the current, as a throttle does, I is behind a first-order lag. Motors with
    different wiring are several tables, one for each motor.
    """

    name = "motor_current"
    stage = "vehicle"
    static = True
    needs = (current_name(1),)
    example = {
        "gain_nT_A": (1.0, -2.0, 3.0),
        "motor": 1,
        "square_nT_A2": (0.2, 0.1, -0.3),
        "cube_nT_A3": (0.03, -0.02, 0.01),
        "lag_s": 0.4,
    }
    traits = Traits(
        experiment=OTHER_THRUST,
        remedy="log the current and take off its field, or twist the supply leads and move them away",
    )

    gain_nT_A: Annotated[Vec3, Quantity("nT/A", -1e9, 1e9, "g forward, left, up", role="linear")] = ZERO3
    motor: Motor = 0
    square_nT_A2: Annotated[Vec3, Quantity("nT/A2", -1e9, 1e9, "g2 forward, left, up", role="linear", form=BENT)] = (
        ZERO3
    )
    cube_nT_A3: Annotated[Vec3, Quantity("nT/A3", -1e9, 1e9, "g3 forward, left, up", role="linear", form=BENT)] = ZERO3
    lag_s: Annotated[
        float,
        Quantity("s", 0.0, 1e5, "time constant of the lag; 0: none", role="listed", tried=LAGS_S, form=LATE_CURRENT),
    ] = 0.0

    def apply(self, state: State, signal_nT: Array, rng: np.random.Generator, memory: Memory) -> Array:
        current = _current(state, self.motor, self.name)
        if self.lag_s > 0:
            current = first_order_lag(current[:, None], self.lag_s, state.interval_s, memory)[:, 0]
        return _field_of(current, array(self.gain_nT_A), array(self.square_nT_A2), array(self.cube_nT_A3))


@kernel
def _field_of(current: Array, gain: Array, square: Array, cube: Array) -> Array:
    """I (g + g2 |I| + g3 I^2) as (n, 3)."""
    field = np.empty((len(current), 3))
    for i in range(len(current)):
        now = current[i]
        for j in range(3):
            field[i, j] = now * (gain[j] + (abs(now) * square[j] + now * now * cube[j]))
    return field


def _harmonic(which: str, form: str, unit: str = "nT/A") -> Quantity:
    """Amplitude of the sine or the cosine of a harmonic."""
    return Quantity(unit, -1e9, 1e9, f"{which} forward, left, up", role="linear", form=form)


@frozen
class CurrentRipple(Effect):
    """Field of a pulsating supply current: ``a I(t) sin(theta(t) + phi)``, ``theta = 2 pi (f t + d t^2 / 2)``.

    Harmonics add ``I(t) (s_k sin(k theta) + c_k cos(k theta))``, k = 2 and 3. A frequency above half the sample rate is
    aliased, as in a sampled instrument.
    """

    name = "current_ripple"
    stage = "vehicle"
    needs = (current_name(1),)
    example = {
        "amplitude_nT_A": (1.0, -2.0, 3.0),
        "frequency_hz": 7.3,
        "phase_deg": 20.0,
        "motor": 2,
        "drift_hz_s": 1e-4,
        "second_sine_nT_A": (0.2, 0.1, 0.3),
        "second_cosine_nT_A": (0.1, -0.1, 0.2),
        "third_sine_nT_A": (0.05, 0.1, 0.0),
        "third_cosine_nT_A": (0.0, 0.02, -0.1),
    }
    traits = Traits(experiment=OTHER_THRUST, remedy="filter the supply, or sample faster and take the tone out")

    amplitude_nT_A: Annotated[Vec3, Quantity("nT/A", -1e9, 1e9, "a forward, left, up", role="linear")] = ZERO3
    frequency_hz: Annotated[float, Quantity("Hz", 0.0, 1e5, "f", role="frequency")] = 1.0
    phase_deg: Annotated[float, Quantity("deg", -360.0, 360.0, "phi at the start of the run", role="phase")] = 0.0
    motor: Motor = 0
    drift_hz_s: Annotated[
        float, Quantity("Hz/s", -10.0, 10.0, "d, by which the frequency changes", role="sweep", form=DRIFT)
    ] = 0.0
    second_sine_nT_A: Annotated[Vec3, _harmonic("s_2", SECOND)] = ZERO3
    second_cosine_nT_A: Annotated[Vec3, _harmonic("c_2", SECOND)] = ZERO3
    third_sine_nT_A: Annotated[Vec3, _harmonic("s_3", THIRD)] = ZERO3
    third_cosine_nT_A: Annotated[Vec3, _harmonic("c_3", THIRD)] = ZERO3

    def apply(self, state: State, signal_nT: Array, rng: np.random.Generator, memory: Memory) -> Array:
        harmonics = (
            (self.second_sine_nT_A, self.second_cosine_nT_A),
            (self.third_sine_nT_A, self.third_cosine_nT_A),
        )
        wave = self.amplitude_nT_A, self.phase_deg
        waves = _waves(state.time_s, self.frequency_hz, self.drift_hz_s, wave, harmonics)
        return _current(state, self.motor, self.name)[:, None] * waves


@frozen
class SteadyTone(Effect):
    """Field of a steady alternating current that no log holds, as of mains or a payload: ``a sin(theta + phi)``.

    ``theta = 2 pi (f t + d t^2 / 2)``; harmonics add ``s_k sin(k theta) + c_k cos(k theta)``, k = 2 and 3. A frequency
    above half the sample rate is aliased, as in a sampled instrument.
    """

    name = "steady_tone"
    stage = "vehicle"
    example = {
        "amplitude_nT": (3.0, -2.0, 4.0),
        "frequency_hz": 3.7,
        "phase_deg": 20.0,
        "drift_hz_s": 1e-4,
        "second_sine_nT": (0.6, 0.3, 0.9),
        "second_cosine_nT": (0.3, -0.3, 0.6),
        "third_sine_nT": (0.2, 0.3, 0.0),
        "third_cosine_nT": (0.0, 0.1, -0.3),
    }
    traits = Traits(
        experiment="switch payloads and converters off one after the other",
        remedy="filter the supply, sample faster and take the tone out, or move the sensor away",
        whole_run=True,
    )

    amplitude_nT: Annotated[Vec3, Quantity("nT", -1e9, 1e9, "a forward, left, up", role="linear")] = ZERO3
    frequency_hz: Annotated[float, Quantity("Hz", 0.0, 1e5, "f", role="frequency")] = 1.0
    phase_deg: Annotated[float, Quantity("deg", -360.0, 360.0, "phi at the start of the run", role="phase")] = 0.0
    drift_hz_s: Annotated[
        float, Quantity("Hz/s", -10.0, 10.0, "d, by which the frequency changes", role="sweep", form=DRIFT)
    ] = 0.0
    second_sine_nT: Annotated[Vec3, _harmonic("s_2", SECOND, "nT")] = ZERO3
    second_cosine_nT: Annotated[Vec3, _harmonic("c_2", SECOND, "nT")] = ZERO3
    third_sine_nT: Annotated[Vec3, _harmonic("s_3", THIRD, "nT")] = ZERO3
    third_cosine_nT: Annotated[Vec3, _harmonic("c_3", THIRD, "nT")] = ZERO3

    def apply(self, state: State, signal_nT: Array, rng: np.random.Generator, memory: Memory) -> Array:
        harmonics = (
            (self.second_sine_nT, self.second_cosine_nT),
            (self.third_sine_nT, self.third_cosine_nT),
        )
        wave = self.amplitude_nT, self.phase_deg
        return _waves(state.time_s, self.frequency_hz, self.drift_hz_s, wave, harmonics)


def _waves(
    t: Array, frequency_hz: float, drift_hz_s: float, wave: tuple[Vec3, float], harmonics: Sequence[tuple[Vec3, Vec3]]
) -> Array:
    """A wave (n, 3) of an amplitude and a phase in degrees, with the sines and cosines of its harmonics in use."""
    theta = (2 * math.pi) * (frequency_hz * t + drift_hz_s / 2 * t**2)
    amplitude, phase_deg = wave
    waves = np.sin(theta + math.radians(phase_deg))[:, None] * array(amplitude)
    for k, (sine, cosine) in enumerate(harmonics, 2):
        if any(sine) or any(cosine):
            waves += np.sin(k * theta)[:, None] * array(sine) + np.cos(k * theta)[:, None] * array(cosine)
    return waves


def _current(state: State, motor: int, name: str) -> Array:
    if not state.motors:
        raise missing_channel(current_name(1), state.channels)
    if motor and motor not in state.motors:
        found = f"motor {motor} asked for, there are {', '.join(map(str, state.motors))}"
        raise InputError(found, where=f"effects.{name}.motor", do="give one of these, or 0 for the sum of all")
    return state.current_of(motor)
