"""What the fuzzer damages: a tiny scenario, its dataset, a measured log and a calibration."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pyarrow as pa

SCENARIO = """name = "tiny"
summary = "a short tumble"
seed = 3
calibrators = ["sphere"]

[field]
enu_nT = [0.0, 20000.0, -40000.0]

[vehicle]
kind = "turntable"

[sampling]
rate_hz = 5.0

[thermal]
surface_degC = 20.0
time_constant_s = 300.0

[navigation]
attitude_noise_std_deg = 0.02
attitude_correlation_s = 60.0

[[phases]]
kind = "tumble"
run_in_s = 1.0
duration_s = 12.0

[[sensors]]
position_m = [0.1, 0.0, 0.0]

[effects.hard_iron]
offset_nT = [200.0, -100.0, 50.0]

[effects.temperature_offset]
slope_nT_K = [8.0, -6.0, 10.0]

[effects.white_noise]
std_nT = [5.0, 5.0, 5.0]

[effects.latency]
delay_s = 0.1

[vary]
"effects.hard_iron.offset_nT" = { uniform = [-400.0, 400.0] }
"""
ROWS = 60


def scenario_in(place: Path) -> Path:
    """The scenario as a file."""
    path = place / "tiny.toml"
    path.write_text(SCENARIO)
    return path


def measured() -> dict[str, Any]:
    """A log of a tumbling sensor with gyro, attitude, temperature, a current and a channel."""
    rng = np.random.default_rng(4)
    time_s = 0.1 * np.arange(ROWS)
    q = rng.standard_normal((ROWS, 4))
    q /= np.linalg.norm(q, axis=1, keepdims=True)
    direction = rng.standard_normal((ROWS, 3))
    field = 45_000 * direction / np.linalg.norm(direction, axis=1, keepdims=True) + [200.0, -100.0, 50.0]
    columns = {"time_s": time_s} | {f"mag_{a}_nT": field[:, i] for i, a in enumerate("xyz")}
    columns |= {f"gyro_{a}_rad_s": rng.standard_normal(ROWS) for a in "xyz"}
    columns |= {f"accel_{a}_m_s2": rng.standard_normal(ROWS) for a in "xyz"}
    columns |= {f"att_q{a}": q[:, i] for i, a in enumerate("wxyz")}
    columns |= {f"pos_{a}_m": rng.standard_normal(ROWS) for a in ("east", "north", "up")}
    return columns | {"temperature_degC": 20 + time_s, "current_1_A": time_s, "wheel_rad_s": time_s**2}


def log_table() -> pa.Table:
    """The same as an Arrow table, with a phase."""
    return pa.table(measured() | {"phase": ["tumble"] * ROWS})


CALIBRATION = {
    "ellipsoid": {
        "name": "ellipsoid",
        "status": "ok",
        "reason": "",
        "offset_nT": [200.0, -100.0, 50.0],
        "matrix": [[1.01, 0.002, 0.0], [0.002, 0.99, 0.0], [0.0, 0.0, 1.0]],
        "eddy_s": [[0.01, 0.0, 0.0], [0.0, 0.01, 0.0], [0.0, 0.0, 0.01]],
        "parameters": {"a": 1.0},
        "covariance": [[4.0, 0.0, 0.0], [0.0, 4.0, 0.0], [0.0, 0.0, 9.0]],
        "covariance_names": ["offset_x_nT", "offset_y_nT", "offset_z_nT"],
        "history": [3.0, 2.0],
        "wall_s": 0.1,
        "array_offset_nT": None,
        "array_matrix": None,
        "segments": [],
    },
    "sphere": {"offset_nT": [1.0, 2.0, 3.0], "matrix": [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]]},
}
