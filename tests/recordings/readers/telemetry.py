"""Telemetry logs as a test lays them out: MAVLink frames by the specification of the protocol."""

from __future__ import annotations

import struct
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np
from dataflash_bytes import DOWN

from recordings import Recording
from scenarios.arrays import Array

START_US = 1_714_564_800 * 10**6
"""The receiver's clock at the start of the autopilot: 1 May 2024, 12 h UTC."""
MESSAGES = {
    "HEARTBEAT": (0, 50, "<IBBBBB"),
    "SYS_STATUS": (1, 124, "<IIIHHhHHHHHHb"),
    "SYSTEM_TIME": (2, 137, "<QI"),
    "PARAM_VALUE": (22, 220, "<fHH16sB"),
    "GPS_RAW_INT": (24, 24, "<QiiiHHHHBB"),
    "RAW_IMU": (27, 144, "<QhhhhhhhhhBh"),
    "ATTITUDE": (30, 39, "<Iffffff"),
    "ATTITUDE_QUATERNION": (31, 246, "<Ifffffff"),
    "LOCAL_POSITION_NED": (32, 185, "<Iffffff"),
    "SERVO_OUTPUT_RAW": (36, 222, "<IHHHHHHHHB"),
    "VFR_HUD": (74, 20, "<ffffhH"),
    "HIGHRES_IMU": (105, 93, "<QfffffffffffffHB"),
    "SCALED_IMU": (26, 170, "<Ihhhhhhhhhh"),
    "SCALED_IMU3": (129, 46, "<Ihhhhhhhhhh"),
    "STATUSTEXT": (253, 83, "<B50s"),
    "SCALED_IMU2": (116, 76, "<Ihhhhhhhhhh"),
    "ESC_TELEMETRY_1_TO_4": (11030, 144, "<4H4H4H4H4H4B"),
}
"""Number, extra byte of the checksum and layout of messages [mavlink.io, common and ardupilotmega]."""


def crc(data: bytes) -> int:
    """X.25's checksum, bit by bit."""
    value = 0xFFFF
    for byte in data:
        value ^= byte
        for _ in range(8):
            value = (value >> 1) ^ (0x8408 if value & 1 else 0)
    return value


@dataclass
class Telemetry:
    """Frames in the order of their times; `delay_s` is the way of the radio."""

    version: int = 2
    delay_s: float = 0.04
    signed: bool = False
    frames: list[tuple[float, bytes]] = field(default_factory=list)

    def add(self, name: str, time_s: float, *values: float | bytes, sender: tuple[int, int] = (1, 1)) -> None:
        """Send a message at a time of the autopilot; version 2 may be signed."""
        number, extra, form = MESSAGES[name]
        whole = [round(v) if code in "bBhHiIQ" else v for v, code in zip(values, _codes(form), strict=True)]
        payload, sequence = struct.pack(form, *whole), len(self.frames) % 256
        if self.version == 2:
            payload = payload.rstrip(b"\0") or b"\0"
            head = bytes([len(payload), int(self.signed), 0, sequence, *sender]) + number.to_bytes(3, "little")
        else:
            head = bytes([len(payload), sequence, *sender, number])
        total = crc(head + payload + bytes([extra]))
        stamp = struct.pack(">Q", round(START_US + (time_s + self.delay_s) * 1e6))
        magic = b"\xfd" if self.version == 2 else b"\xfe"
        signature = bytes(range(0xF0, 0xFD)) if self.signed and self.version == 2 else b""
        self.frames.append((time_s, stamp + magic + head + payload + struct.pack("<H", total) + signature))

    def write(self, path: Path) -> Path:
        """Write the log to a file."""
        path.write_bytes(b"".join(frame for _, frame in sorted(self.frames, key=lambda one: one[0])))
        return path


def _codes(form: str) -> list[str]:
    """A code for each value of a layout; a text is one value."""
    codes, count = [], ""
    for character in form[1:]:
        if character.isdigit():
            count += character
            continue
        codes += [character] * (1 if character == "s" else int(count or 1))
        count = ""
    return codes


def milligauss(field_nT: Array) -> Array:
    """A field (n, 3) in FLU as whole mG in FRD, cut toward zero."""
    return np.trunc(field_nT * DOWN / 100)


def write_telemetry(recording: Recording, path: Path) -> None:
    """Write a recording as PX4 sends it, in single precision: field in gauss, rates, forces, temperature, position."""
    log, at_s = Telemetry(), recording.time_s
    rates, forces = (np.atleast_2d(x) * DOWN for x in (recording.gyro_rad_s, recording.accel_m_s2))
    degrees, field_G = np.atleast_1d(recording.temperature_degC), recording.mag_nT * DOWN / 1e5
    for k, time_s in enumerate(at_s.tolist()):
        heat = float(degrees[k])
        log.add("HIGHRES_IMU", time_s, time_s * 1e6, *forces[k], *rates[k], *field_G[k], 0, 0, 0, heat, 0, 0)
        east, north, up = np.atleast_2d(recording.pos_enu_m)[k]
        log.add("LOCAL_POSITION_NED", time_s, time_s * 1e3, north, east, -up, 0, 0, 0)
    log.write(path)
