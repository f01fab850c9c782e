"""A simulated flight, and what PX4 makes of its magnetic field: the formulas of its sources, written again by axis."""

from __future__ import annotations

from dataclasses import dataclass, field
from functools import cached_property

import numpy as np
from scipy.spatial.transform import Rotation
from ulog_bytes import TopicOf, vector

Array = np.ndarray
FIELD_ENU = np.array([1_500.0, 21_000.0, -43_000.0])
"""A field of central Europe, which points down."""
HARD_IRON = np.array([9_000.0, -14_000.0, 6_500.0])
SOFT_IRON = np.array([[1.08, 0.03, -0.02], [0.03, 0.95, 0.04], [-0.02, 0.04, 1.02]])
NED_OF_ENU = np.array([[0.0, 1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, -1.0]])
FRD_OF_FLU = np.diag([1.0, -1.0, -1.0])


@dataclass(frozen=True)
class Flight:
    """Twenty seconds of smooth turns about all axes, at the magnetometer's times."""

    time_s: Array = field(default_factory=lambda: 100.0 + np.arange(400) * 0.05)

    def attitude(self, time_s: Array) -> Rotation:
        """Body (FLU) to world (ENU)."""
        t = time_s - 100.0
        angles = np.column_stack([0.4 * t + 0.3 * np.sin(t), 0.5 * np.sin(0.9 * t), 0.7 * np.sin(0.6 * t + 1)])
        return Rotation.from_euler("ZYX", angles)

    def rate_rad_s(self, time_s: Array) -> Array:
        """Body rate (n, 3), FLU, by a difference of attitudes over 2 ms."""
        before, after = self.attitude(time_s - 1e-3), self.attitude(time_s + 1e-3)
        return np.asarray((before.inv() * after).as_rotvec() / 2e-3)

    @cached_property
    def field_nT(self) -> Array:
        """The Earth's field in the body frame, FLU."""
        return self.attitude(self.time_s).apply(FIELD_ENU, inverse=True)

    @cached_property
    def measured_nT(self) -> Array:
        """What the magnetometer measures along the body's axes, FLU, with iron."""
        return self.field_nT @ SOFT_IRON.T + HARD_IRON

    def sensor_G(self, mounting: Rotation) -> Array:
        """What the magnetometer measures in its own axes (FRD where mounted straight); body = mounting sensor."""
        return mounting.apply(self.measured_nT @ FRD_OF_FLU / 1e5, inverse=True)

    @property
    def throttle(self) -> Array:
        return 0.5 + 0.3 * np.sin(self.time_s)

    @property
    def current_A(self) -> Array:
        return 15.0 + 9.0 * np.cos(0.7 * self.time_s)


@dataclass(frozen=True)
class Calibration:
    """The parameters of a magnetometer, in PX4's units and order."""

    offset: tuple[float, float, float] = (0.0, 0.0, 0.0)
    scale: tuple[float, float, float] = (1.0, 1.0, 1.0)
    off_diagonal: tuple[float, float, float] = (0.0, 0.0, 0.0)
    power: tuple[float, float, float] = (0.0, 0.0, 0.0)

    def parameters(self, slot: int, device: int, mounting: int, *, new: bool = True) -> dict[str, float]:
        """CAL_MAGn_*, of v1.12 and later, or of v1.11."""
        own = {"OFF": self.offset, "SCALE": self.scale, "COMP": self.power}
        own |= {"ODIAG": self.off_diagonal} if new else {}
        found: dict[str, float] = {
            f"CAL_MAG{slot}_{axis}{name}": float(value)
            for name, values in own.items()
            for axis, value in zip("XYZ", values, strict=True)
        }
        found |= {f"CAL_MAG{slot}_ID": device, f"CAL_MAG{slot}_ROT": mounting}
        return found | ({f"CAL_MAG{slot}_PRIO": 75} if new else {f"CAL_MAG{slot}_EN": 1})

    def newest(self, x: Array, power: Array, mounting: Rotation, bias: Array | None = None) -> Array:
        """`Correct` of Magnetometer.hpp, and the bias that VehicleMagnetometer.cpp takes off."""
        a, b, c = (x[:, k] + power * self.power[k] - self.offset[k] for k in range(3))
        (sx, sy, sz), (xy, xz, yz) = self.scale, self.off_diagonal
        scaled = np.column_stack([sx * a + xy * b + xz * c, xy * a + sy * b + yz * c, xz * a + yz * b + sz * c])
        return mounting.apply(scaled) - (0.0 if bias is None else bias)

    def driver(self, x: Array) -> Array:
        """`sensor_mag` of v1.11 and before."""
        return np.column_stack([(x[:, k] - self.offset[k]) * self.scale[k] for k in range(3)])

    def older(self, x: Array, power: Array, mounting: Rotation) -> Array:
        """`vehicle_magnetometer` of v1.11."""
        return mounting.apply(self.driver(x) + power[:, None] * np.array(self.power))


def vehicle_magnetometer(flight: Flight, body_G: Array, device: int | None, every: int = 1) -> TopicOf:
    """The topic; no device number in v1.11."""
    time_s = flight.time_s[::every]
    number = {} if device is None else {"device_id": ("uint32_t", np.full(len(time_s), device))}
    stamp = {} if device is None else {"timestamp_sample": ("uint64_t", np.round(time_s * 1e6).astype(int))}
    later_s = time_s if device is None else time_s + 0.003
    return TopicOf("vehicle_magnetometer", later_s, stamp | number | vector("magnetometer_ga", body_G[::every]))
