"""The instruments beside the magnetometer: gyro, accelerometer, navigation, thermometer, current sensors."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from scenarios.arrays import Array
from scenarios.seeds import stream
from scenarios.spec import NavigationSpec
from sim.late_attitude import LateAttitude
from sim.motion import Motion
from sim.processes import GaussMarkov
from sim.rotation import multiply_q, q_from_rotation_vector, to_body

GRAVITY_ENU_M_S2 = np.array([[0.0, 0.0, -9.81]])


@dataclass
class Instruments:
    """Measured motion from true motion, block by block.

    gyro = w + b_g + n,  accel = R_wb^T (a - g) + b_a + n,  attitude = exp(e) R_d R_wb(t - delay) with e a
    Gauss-Markov rotation vector (ENU) and R_d the initial alignment error (the effect `attitude_misalignment`),
    position = p + Gauss-Markov error.
    """

    spec: NavigationSpec
    seed: int
    run: int
    interval_s: float
    alignment_q: Array

    def __post_init__(self) -> None:
        s, draw = self.spec, self._stream
        self.gyro_bias = s.gyro_bias_std_rad_s * draw("gyro bias").standard_normal(3)
        self.accel_bias = s.accel_bias_std_m_s2 * draw("accelerometer bias").standard_normal(3)
        attitude_std = np.radians(s.attitude_noise_std_deg)
        self.attitude_error = GaussMarkov(attitude_std, s.attitude_correlation_s, self.interval_s, 3, draw("attitude"))
        self.position_error = GaussMarkov(
            s.position_noise_std_m, s.position_correlation_s, self.interval_s, 3, draw("position")
        )
        self.late = LateAttitude(s.attitude_delay_s)
        self.white = {name: draw(name) for name in ("gyro", "accelerometer", "temperature", "current")}

    def _stream(self, name: str) -> np.random.Generator:
        return stream(self.seed, self.run, "instruments", name)

    def _noise(self, name: str, std: float, shape: tuple[int, ...]) -> Array:
        return std * self.white[name].standard_normal(shape)

    def measure(self, motion: Motion, temperature_degC: Array) -> dict[str, Array]:
        """Arrays named as in Recording (gyro_rad_s (n, 3), att_q (n, 4), ...) from one block of true motion."""
        k, s, n = motion.kinematics, self.spec, len(motion.time_s)
        error_q = q_from_rotation_vector(self.attitude_error.draw(n))
        aligned = multiply_q(np.broadcast_to(self.alignment_q, (n, 4)), self.late.of(motion.time_s, k.q))
        force = to_body(motion.R_wb, k.accel_m_s2 - GRAVITY_ENU_M_S2)
        return {
            "gyro_rad_s": k.rate_rad_s + self.gyro_bias + self._noise("gyro", s.gyro_noise_std_rad_s, (n, 3)),
            "accel_m_s2": force + self.accel_bias + self._noise("accelerometer", s.accel_noise_std_m_s2, (n, 3)),
            "att_q": multiply_q(error_q, aligned),
            "pos_enu_m": k.pos_enu_m + self.position_error.draw(n),
            "temperature_degC": temperature_degC + self._noise("temperature", s.temperature_noise_std_K, (n,)),
            "current_A": motion.current_A
            + self._noise("current", s.current_noise_std_A, (n, motion.current_A.shape[1])),
        }
