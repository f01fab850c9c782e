"""The tables that makers of inertial units export: names of columns, units and frames that their formats fix."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

from recordings.reading import COUNT

Three = tuple[str, str, str]


@dataclass(frozen=True)
class Maker:
    """A maker's export: bare names of columns, of which the first vector that is there counts.

    mark : one of these sets of columns is there. unit : of the magnetometer where its columns tell none. gyro, accel :
    vectors and their unit. angles, radians : roll, pitch, yaw, of FRD in NED where `down`. quaternion : w x y z.
    down : whether the axes are forward, right, down. times : columns of time and the unit of each. upside_down :
    whether the accelerometer measures gravity, down at rest.
    """

    name: str
    mark: tuple[frozenset[str], ...]
    mag: tuple[Three, ...]
    unit: str
    gyro: tuple[Three, ...]
    gyro_unit: str
    accel: tuple[Three, ...]
    accel_unit: str
    times: Mapping[str, str]
    down: bool
    angles: tuple[Three, ...] = ()
    radians: tuple[Three, ...] = ()
    quaternion: tuple[str, ...] = ()
    note: str = ""
    upside_down: bool = False


def _three(*forms: str) -> tuple[Three, ...]:
    return tuple((form.format("x"), form.format("y"), form.format("z")) for form in forms)


MAKERS = (
    Maker(
        name="Xsens",
        mark=(frozenset({"packetcounter", "mag_x"}),),
        mag=_three("mag_{}"),
        unit=COUNT,
        gyro=_three("gyr_{}"),
        gyro_unit="rad/s",
        accel=_three("acc_{}"),
        accel_unit="m/s^2",
        times={},
        down=False,
        angles=(("roll", "pitch", "yaw"), ("euler_x", "euler_y", "euler_z")),
        quaternion=("quat_q0", "quat_q1", "quat_q2", "quat_q3"),
        note="the magnetometer is in units of the field at the factory: the gain is not known",
    ),
    Maker(
        name="VectorNav",
        mark=(frozenset({"uncompmagx"}), frozenset({"magx", "accelx", "angularratex"})),
        mag=_three("uncompmag{}", "mag{}"),
        unit="G",
        gyro=_three("angularrate{}", "uncompgyro{}", "gyro{}"),
        gyro_unit="rad/s",
        accel=_three("accel{}", "uncompaccel{}", "uncompacc{}", "acc{}"),
        accel_unit="m/s^2",
        times={"timestartup": "ns", "time": "s"},
        down=True,
        angles=(("roll", "pitch", "yaw"), ("yawpitchroll[2]", "yawpitchroll[1]", "yawpitchroll[0]")),
        note="the uncompensated magnetometer first: without it the unit's own calibration is in the field",
    ),
    Maker(
        name="SBG",
        mark=(frozenset({"magx", "accelx", "status"}),),
        mag=_three("mag{}"),
        unit=COUNT,
        gyro=_three("gyro{}"),
        gyro_unit="deg/s",
        accel=_three("accel{}"),
        accel_unit="m/s^2",
        times={"timestamp": "us"},
        down=True,
        angles=(("roll", "pitch", "yaw"),),
        note="the magnetometer is in arbitrary units, with the unit's own calibration",
    ),
    Maker(
        name="DJI",
        mark=(frozenset({"imu_atti:magx"}), frozenset({"imu_atti:mag:x"})),
        mag=_three("imu_atti:mag{}", "imu_atti:mag:{}"),
        unit=COUNT,
        gyro=_three("imu_atti:gyro{}", "imu_atti:gyro:{}"),
        gyro_unit="deg/s",
        accel=_three("imu_atti:accel{}", "imu_atti:accel:{}"),
        accel_unit="g",
        times={"clock:offsettime": "s", "offsettime": "s"},
        down=True,
        quaternion=tuple(f"imu_atti:quat{part}" for part in "wxyz"),
        note="the unit of the magnetometer is not agreed on: read as counts",
    ),
    Maker(
        name="MicroStrain",
        mark=(frozenset({"scaledmagx", "scaledaccelx"}), frozenset({"xmag", "xaccel"})),
        mag=_three("scaledmag{}", "{}mag"),
        unit="G",
        gyro=_three("scaledgyro{}", "{}gyro"),
        gyro_unit="rad/s",
        accel=_three("scaledaccel{}", "{}accel"),
        accel_unit="g",
        times={"gpstow": "s"},
        down=True,
        radians=(("roll", "pitch", "yaw"),),
        note="the magnetometer has the unit's own calibration",
    ),
    Maker(
        name="SensorLog (iOS)",
        mark=(frozenset({"magnetometerx", "accelerometeraccelerationx"}),),
        mag=_three("magnetometer{}"),
        unit="uT",
        gyro=_three("gyrorotation{}"),
        gyro_unit="rad/s",
        accel=_three("accelerometeracceleration{}"),
        accel_unit="g",
        times={"magnetometertimestamp_sincereboot": "s"},
        down=False,
        upside_down=True,
        note="the raw magnetometer; an iPhone's accelerations have the sign of gravity, turned",
    ),
)
"""Frames and units of the tables of MT Manager, VectorNav's SDK, sbgBasicLogger and DatCon."""
