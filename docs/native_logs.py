"""Writes `docs/logs/flight.bin` and `docs/logs/flight.ulg`: one simulated flight as ArduPilot and as PX4 log it.

The parameters in force are a little wrong, as those of a vehicle that was calibrated before its payload changed. The
files are the same bytes every time. Run `PYTHONPATH=. python docs/native_logs.py`.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np
from dataflash_bytes import DOWN, Log, write_compass
from native_flight import IRON_NT, PLACE, START_S, UTC, QuadrotorFlight, quadrotor_flight
from ulog_bytes import TopicOf, UlogOf, vector, xyz

from scenarios.arrays import Array

LOGS = Path(__file__).parent / "logs"
SEED = 32
OLD_OFFSET_NT = IRON_NT + np.array([-900.0, 700.0, 600.0])
"""The offset that the autopilots take off, in FLU."""
MAG_EVERY, GPS_EVERY = 3, 25
METRES_A_DEGREE = 111_200.0
GEOID_M = 46.0
"""The sea level there above the ellipsoid."""
GPS_EPOCH_S = 315_964_800 - 18
"""UTC of GPS's beginning less the leap seconds since, in s since 1970."""
DEVICE = 396_809
LOITER, GUIDED_BY_HAND = 5, 0


def positions(flight: QuadrotorFlight, time_s: Array) -> tuple[Array, Array, Array]:
    """Latitude and longitude in degrees, altitude in m."""
    east, north, up = flight.enu_m(time_s).T
    east_deg = east / (METRES_A_DEGREE * np.cos(np.radians(PLACE[0])))
    return PLACE[0] + north / METRES_A_DEGREE, PLACE[1] + east_deg, PLACE[2] + up


def ardupilot_log(flight: QuadrotorFlight) -> bytes:
    """The flight as ArduCopter 4.6 logs it, with its compass calibration in force."""
    log, at_s = Log(), flight.time_s
    log.layout("MSG", "QZ", "TimeUS,Message")
    log.add("MSG", START_S, "ArduCopter V4.6.2 (simulated)")
    offset_mG = -OLD_OFFSET_NT * DOWN / 100
    log.parameters(START_S, **{f"COMPASS_OFS_{a}": float(x) for a, x in zip("XYZ", offset_mG, strict=True)})
    log.parameters(START_S, COMPASS_DEV_ID=97_539, COMPASS_ORIENT=0, COMPASS_USE=1, COMPASS_MOTCT=0)
    mag_s = at_s[::MAG_EVERY]
    measured = flight.measured_nT(mag_s, np.random.default_rng(SEED))
    write_compass(log, mag_s, measured + 100 * offset_mG * DOWN, offset_mG=offset_mG)
    write_state(log, flight)
    return log.data()


def write_state(log: Log, flight: QuadrotorFlight) -> None:
    """Write inertial unit, attitude, battery, satellites, modes and arming."""
    at_s, slow_s = flight.time_s, flight.time_s[::GPS_EVERY]
    log.layout("IMU", "QBfffffff", "TimeUS,I,GyrX,GyrY,GyrZ,AccX,AccY,AccZ,T")
    rate, force = flight.rate_rad_s(at_s) * DOWN, flight.force_m_s2(at_s) * DOWN
    log.rows("IMU", at_s, 0, *rate.T, *force.T, 38.0 + 0.01 * (at_s - START_S))
    log.layout("XKQ", "QBffff", "TimeUS,C,Q1,Q2,Q3,Q4")
    log.rows("XKQ", at_s, 0, *flight.ned(at_s).T)
    log.layout("BAT", "QBff", "TimeUS,Inst,Volt,Curr")
    power_s = at_s[::MAG_EVERY]
    log.rows("BAT", power_s, 0, 16.4 - 0.02 * flight.current_A(power_s), flight.current_A(power_s))
    log.layout("GPS", "QBBIHBLLe", "TimeUS,I,Status,GMS,GWk,NSats,Lat,Lng,Alt")
    week, within_s = divmod(UTC.timestamp() - GPS_EPOCH_S + slow_s - START_S, 7 * 86_400)
    log.rows("GPS", slow_s, 0, 3, np.round(1000 * within_s), week, 14, *positions(flight, slow_s))
    log.layout("MODE", "QMBB", "TimeUS,Mode,ModeNum,Rsn")
    log.add("MODE", START_S, GUIDED_BY_HAND, GUIDED_BY_HAND, 1)
    log.add("MODE", flight.take_off_s, LOITER, LOITER, 1)
    log.layout("ARM", "QBI", "TimeUS,ArmState,ArmChecks")
    log.add("ARM", flight.take_off_s, 1, 0)


def px4_log(flight: QuadrotorFlight) -> bytes:
    """The flight as PX4 1.15 logs it, with its calibration of magnetometer 0 in force."""
    offset_G = OLD_OFFSET_NT * DOWN / 1e5
    parameters: dict[str, float] = {f"CAL_MAG0_{a}OFF": float(x) for a, x in zip("XYZ", offset_G, strict=True)}
    parameters |= {f"CAL_MAG0_{a}SCALE": 1.0 for a in "XYZ"}
    parameters |= {"CAL_MAG0_ID": DEVICE, "CAL_MAG0_ROT": 0, "CAL_MAG0_PRIO": 75, "CAL_MAG_COMP_TYP": 0}
    topics = [*compass_topics(flight, offset_G), *state_topics(flight)]
    return UlogOf(topics, parameters, release=(1, 15, 2)).bytes()


def compass_topics(flight: QuadrotorFlight, offset_G: Array) -> list[TopicOf]:
    """The magnetometer as it is, and as PX4 corrects it."""
    mag_s = flight.time_s[::MAG_EVERY]
    raw_G = flight.measured_nT(mag_s, np.random.default_rng(SEED)) * DOWN / 1e5
    stamp = {"timestamp_sample": ("uint64_t", np.round(mag_s * 1e6).astype(int))}
    device = {"device_id": ("uint32_t", np.full(len(mag_s), DEVICE))}
    warm = {"temperature": ("float", 34.0 + 0.01 * (mag_s - START_S))}
    corrected = vector("magnetometer_ga", raw_G - offset_G)
    return [
        TopicOf("sensor_mag", mag_s, stamp | device | xyz(raw_G) | warm),
        TopicOf("vehicle_magnetometer", mag_s + 0.003, stamp | device | corrected),
    ]


def state_topics(flight: QuadrotorFlight) -> list[TopicOf]:
    """Inertial unit, attitude, battery, satellites and modes."""
    at_s, slow_s = flight.time_s, flight.time_s[::GPS_EVERY]
    power_s = at_s[::MAG_EVERY]
    motion = {
        "gyro_rad": ("float", flight.rate_rad_s(at_s) * DOWN),
        "accelerometer_timestamp_relative": ("int32_t", np.zeros(len(at_s), dtype=int)),
        "accelerometer_m_s2": ("float", flight.force_m_s2(at_s) * DOWN),
    }
    current_A = flight.current_A(power_s)
    power = {"current_a": ("float", current_A), "voltage_v": ("float", 16.4 - 0.02 * current_A)}
    flying = slow_s >= flight.take_off_s
    status = {"nav_state": ("uint8_t", np.where(flying, 4, 0)), "arming_state": ("uint8_t", np.where(flying, 2, 1))}
    return [
        TopicOf("sensor_combined", at_s, motion),
        TopicOf("vehicle_attitude", at_s, {"q": ("float", flight.ned(at_s))}),
        TopicOf("battery_status", power_s, power),
        TopicOf("sensor_gps", slow_s, satellites(flight, slow_s)),
        TopicOf("vehicle_status", slow_s, status),
    ]


def satellites(flight: QuadrotorFlight, time_s: Array) -> dict[str, tuple[str, Array]]:
    """The fields of sensor_gps."""
    latitude, longitude, altitude = positions(flight, time_s)
    utc_us = np.round(1e6 * (UTC.timestamp() + time_s - START_S)).astype(int)
    return {
        "time_utc_usec": ("uint64_t", utc_us),
        "fix_type": ("uint8_t", np.full(len(time_s), 3)),
        "latitude_deg": ("double", latitude),
        "longitude_deg": ("double", longitude),
        "altitude_msl_m": ("double", altitude - GEOID_M),
        "altitude_ellipsoid_m": ("double", altitude),
    }


def main() -> None:
    """Write both logs."""
    flight = quadrotor_flight()
    LOGS.mkdir(exist_ok=True)
    (LOGS / "flight.bin").write_bytes(ardupilot_log(flight))
    (LOGS / "flight.ulg").write_bytes(px4_log(flight))


if __name__ == "__main__":
    main()
