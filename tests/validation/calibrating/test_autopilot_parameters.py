"""Exported parameters, put through the autopilots' formulas written again here, give the field that `apply` gives."""

from __future__ import annotations

import re
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

import magbench
from calib import Calibration, Status
from calib.input_terms import InputTerm
from recordings import Origin, Recording
from recordings.applied import AppliedCalibration
from scenarios.errors import InputError
from validation.calibrating.export import exported

FRD = np.array([1.0, -1.0, -1.0])
MATRIX = np.array([[0.95, 0.02, -0.01], [0.02, 1.05, 0.03], [-0.01, 0.03, 1.01]])
IRON = Calibration(
    name="motor_ellipsoid", status=Status("ok"), offset_nT=np.array([12_000.0, -8_000.0, 20_000.0]), matrix=MATRIX
)
GAIN_NT = np.array([61.2, -40.7, 93.1])
TIME_S = 0.02 * np.arange(400)
RNG = np.random.default_rng(3)
CURRENT_A = RNG.uniform(0.0, 30.0, (400, 4))
LOG = Recording(
    TIME_S, RNG.normal(0.0, 30_000.0, (400, 3)), current_A=CURRENT_A, channels={"throttle": RNG.random(400)}
)
SUM = replace(IRON, inputs=(InputTerm("current_sum_A", GAIN_NT),))
THROTTLE = replace(IRON, inputs=(InputTerm("throttle", 40.0 * GAIN_NT, 0.25),))
POWERED = pytest.mark.parametrize(
    ("calibration", "power", "kind"),
    [(IRON, np.zeros(400), 0), (THROTTLE, LOG.channels["throttle"], 1), (SUM, CURRENT_A.sum(axis=1), 2)],
    ids=["iron", "throttle", "current"],
)


def values(text: str) -> dict[str, float]:
    """As QGroundControl (five columns between tabs) and Mission Planner (name, value) read a file."""
    lines = [line for line in text.splitlines() if not line.startswith("#")]
    tabbed = [line.split("\t") for line in lines if "\t" in line]
    assert all(len(cells) == 5 and cells[4] in ("6", "9") for cells in tabbed)
    assert all(re.fullmatch(r"-?\d+", cells[3]) for cells in tabbed if cells[4] == "6")
    comma = [line.split(",") for line in lines if "\t" not in line]
    return {cells[2]: float(cells[3]) for cells in tabbed} | {name: float(value) for name, value in comma}


def symmetric(diagonal: list[float], xy: float, xz: float, yz: float) -> np.ndarray:
    return np.diag(diagonal) + np.array([[0, xy, xz], [xy, 0, yz], [xz, yz, 0]])


def ardupilot_field_nT(p: dict[str, float], n: str, raw_nT: np.ndarray, power: np.ndarray) -> np.ndarray:
    """M (s (raw + o)) + k p, milligauss, FRD."""
    o, k = ([p.get(f"COMPASS_{word}{n}_{a}", 0.0) for a in "XYZ"] for word in ("OFS", "MOT"))
    m = symmetric([p[f"COMPASS_DIA{n}_{a}"] for a in "XYZ"], *(p[f"COMPASS_ODI{n}_{a}"] for a in "XYZ"))
    field_mG = (p[f"COMPASS_SCALE{n}"] * (raw_nT * FRD / 100.0 + o)) @ m + power[:, None] * k
    return 100.0 * FRD * field_mG


def px4_field_nT(p: dict[str, float], n: int, raw_nT: np.ndarray, power: np.ndarray, turn: np.ndarray) -> np.ndarray:
    """R S ((x + P c) - o), gauss; x in sensor axes (FRD), R from them to the body."""
    c, o, d, u = ([p.get(f"CAL_MAG{n}_{a}{end}", 0.0) for a in "XYZ"] for end in ("COMP", "OFF", "SCALE", "ODIAG"))
    per_unit = 1e-3 if p.get("CAL_MAG_COMP_TYP") in (2.0, 3.0) else 1.0
    x = raw_nT * FRD / 1e5 @ turn
    body = ((x + per_unit * power[:, None] * c) - o) @ symmetric(d, *u) @ turn.T
    return 1e5 * FRD * body


@POWERED
@pytest.mark.parametrize("compass", [1, 2, 3])
def test_ardupilot(calibration: Calibration, power: np.ndarray, kind: int, compass: int) -> None:
    n = "" if compass == 1 else str(compass)
    force = {f"COMPASS_DEV_ID{n}": 97539.0, f"COMPASS_ORIENT{n}": 6.0, f"COMPASS_OFS{n}_X": 3.0}
    p = values(
        exported(calibration, "ardupilot", applied=AppliedCalibration("ardupilot", compass, parameters=force))[1]
    )
    assert p.get("COMPASS_MOTCT", 0) == kind
    assert (p[f"COMPASS_DEV_ID{n}"], p[f"COMPASS_ORIENT{n}"]) == (97539, 6)
    np.testing.assert_allclose(ardupilot_field_nT(p, n, LOG.mag_nT, power), calibration.apply(LOG), atol=0.1)


@POWERED
@pytest.mark.parametrize(
    ("mounting", "angles_deg"),
    [
        ({}, (0, 0, 0)),
        ({"ROT": 6}, (270, 0, 0)),
        ({"ROT": 26}, (90, 180, 0)),
        ({"ROT": 100, "ROLL": 20.0, "YAW": 50.0}, (50, 0, 20)),
    ],
)
def test_px4(
    calibration: Calibration, power: np.ndarray, kind: int, mounting: dict[str, float], angles_deg: tuple[float, ...]
) -> None:
    turn = Rotation.from_euler("ZYX", angles_deg, degrees=True).as_matrix()
    force = {f"CAL_MAG1_{key}": float(value) for key, value in mounting.items()} | {"CAL_MAG1_ID": 396809.0}
    p = values(exported(calibration, "px4", applied=AppliedCalibration("px4", 1, parameters=force))[1])
    assert p.get("CAL_MAG_COMP_TYP", 0) == kind
    assert p["CAL_MAG1_ID"] == 396809
    assert p.get("CAL_MAG1_ROT") == mounting.get("ROT")
    np.testing.assert_allclose(px4_field_nT(p, 1, LOG.mag_nT, power, turn), calibration.apply(LOG), atol=0.1)


def test_px4_board_mountings_and_level() -> None:
    force = {"CAL_MAG0_ROT": -1.0, "SENS_BOARD_ROT": 4.0, "SENS_BOARD_X_OFF": 3.0}
    turn = Rotation.from_euler("x", 3, degrees=True) * Rotation.from_euler("z", 180, degrees=True)
    p = values(exported(SUM, "px4", applied=AppliedCalibration("px4", 0, parameters=force))[1])
    found = px4_field_nT(p, 0, LOG.mag_nT, CURRENT_A.sum(axis=1), turn.as_matrix())
    np.testing.assert_allclose(found, SUM.apply(LOG), atol=0.1)


@pytest.mark.parametrize("angles_deg", [(0, 0, 90), (50, 0, 20)], ids=["on its side", "oblique"])
def test_a_level_turn_of_a_tilted_px4_sensor_keeps_what_is_along_the_vehicles_z(angles_deg: tuple[float, ...]) -> None:
    """x and y of the field follow the new calibration, z the parameters in force, whatever the sensor's axes."""
    turn = Rotation.from_euler("ZYX", angles_deg, degrees=True).as_matrix()
    before = {"XOFF": 0.11, "YOFF": -0.07, "ZOFF": 0.05, "XSCALE": 1.06, "YSCALE": 0.94, "ZSCALE": 1.02}
    before |= {"XODIAG": 0.03, "YODIAG": -0.02, "ZODIAG": 0.04, "ROT": 100.0, "ID": 396809.0}
    before |= dict(zip(("YAW", "PITCH", "ROLL"), map(float, angles_deg), strict=True))
    force = {f"CAL_MAG0_{name}": value for name, value in before.items()}
    level = np.array([[0.95, 0.02, 0.0], [0.02, 1.05, 0.0], [0.0, 0.0, 1.0]])
    planar = replace(
        IRON,
        offset_nT=np.array([12_000.0, -8_000.0, 0.0]),
        matrix=level,
        covariance=np.eye(2),
        covariance_names=("offset_x_nT", "offset_y_nT"),
    )
    assert not planar.determines_z
    text = exported(planar, "px4", applied=AppliedCalibration("px4", 0, parameters=force))[1]
    assert "the sensor is tilted" in text
    offset, scale = (
        turn @ np.array([before[f"{axis}OFF"] for axis in "XYZ"]),
        turn @ symmetric([1.06, 0.94, 1.02], 0.03, -0.02, 0.04) @ turn.T,
    )
    offset[:2] = [0.12, 0.08]
    scale[:2, :2] = [[0.95, -0.02], [-0.02, 1.05]]
    expected = 1e5 * FRD * ((LOG.mag_nT * FRD / 1e5 - offset) @ scale.T)
    found = px4_field_nT(values(text), 0, LOG.mag_nT, np.zeros(400), turn)
    np.testing.assert_allclose(found, expected, atol=0.1)
    upright = exported(planar, "px4", applied=AppliedCalibration("px4", 0, parameters=force | {"CAL_MAG0_ROT": 2.0}))
    assert "CAL_MAG0_ZOFF" not in values(upright[1])


def test_a_mounting_that_px4_has_not_is_named() -> None:
    with pytest.raises(InputError, match="no mounting of number 77"):
        exported(IRON, "px4", applied=AppliedCalibration("px4", 0, parameters={"CAL_MAG0_ROT": 77.0}))


@pytest.mark.parametrize(("form", "head"), [("ardupilot", "COMPASS_MOT_"), ("px4", "CAL_MAG0_")])
def test_a_compensation_in_force_is_switched_off_where_none_was_fitted(form: str, head: str) -> None:
    """The log's field has the motors' in it, undone: with the compensation it would be taken off twice."""
    end = "COMP" if form == "px4" else ""
    force = {f"{head}{axis}{end}": 2.0 for axis in "XYZ"}
    applied = AppliedCalibration(form, 0 if form == "px4" else 1, parameters=force)
    name, text = exported(IRON, form, applied=applied)
    assert [values(text)[key] for key in force] == [0.0, 0.0, 0.0], name
    assert "set to 0" in text
    assert not set(force) & set(values(exported(IRON, form)[1]))


def test_parameters_of_another_autopilot_name_nothing() -> None:
    applied = AppliedCalibration("px4", 2, parameters={"CAL_MAG2_ID": 5.0})
    assert exported(IRON, "ardupilot", applied=applied) == exported(IRON, "ardupilot")


@pytest.mark.parametrize("form", ["ardupilot", "px4"])
def test_what_the_parameters_cannot_hold_is_said(form: str) -> None:
    each = replace(IRON, inputs=tuple(InputTerm(f"current_{k}_A", GAIN_NT) for k in (1, 2)))
    warm = replace(SUM, inputs=(*SUM.inputs, InputTerm("temperature_degC", GAIN_NT, 24.0)))
    late = replace(IRON, inputs=(replace(SUM.inputs[0], lag_s=0.3),))
    with pytest.raises(InputError, match="terms of each motor"):
        exported(each, form, force=True)
    with pytest.raises(InputError, match=r"field of temperature_degC .* is left out: the offset holds at 24"):
        exported(warm, form)
    assert "lag of 0.3 s" in exported(late, form)[1]


def test_px4_says_what_it_ignores() -> None:
    small = replace(IRON, offset_nT=np.array([300.0, 0.0, -500.0]), matrix=np.diag([1.002, 1.0, 0.999]))
    text = exported(small, "px4")[1]
    assert "ignores a change of the offset of 0.01 or less; this one is 0.0058 G" in text
    assert "ignores a change of the scales" in text
    assert "ignores" not in exported(IRON, "px4")[1].replace("off-diagonals", "")


def test_ros_covariance_is_the_scatter_of_corrected_samples() -> None:
    covariance_nT2 = np.diag([9.0, 4.0, 16.0])
    noisy = replace(
        SUM,
        parameters={"noise_std_nT": 5.0},
        covariance=covariance_nT2,
        covariance_names=("offset_x_nT", "offset_y_nT", "offset_z_nT"),
    )
    found = re.search(r"magnetic_field_covariance: \[(.*)\]", exported(noisy, "ros")[1])
    assert found is not None
    rng = np.random.default_rng(0)
    offsets = rng.multivariate_normal(np.zeros(3), covariance_nT2, 200_000) + rng.normal(0.0, 5.0, (200_000, 3))
    stated = 1e18 * np.array(found[1].split(","), float).reshape(3, 3)
    np.testing.assert_allclose(stated, np.cov((offsets @ MATRIX.T).T), atol=0.5)
    assert 'channel: "current_sum_A"' in exported(noisy, "ros")[1]


def test_calibrate_exports_for_the_compass_of_the_log(tmp_path: Path) -> None:
    rng = np.random.default_rng(5)
    h = Rotation.random(600, rng=rng).apply([48_000.0, 0.0, 0.0])
    applied = AppliedCalibration("px4", 2, parameters={"CAL_MAG2_ID": 131.0, "CAL_MAG2_ROT": 2.0})
    log = Recording(
        np.arange(600.0),
        h @ np.linalg.inv(MATRIX) + IRON.offset_nT + rng.normal(0.0, 5.0, (600, 3)),
        origin=Origin(applied=applied),
    )
    magbench.calibrate(log, 48_000.0, with_="ellipsoid", out=tmp_path, exports=["px4"])
    p = values((tmp_path / "px4.params").read_text())
    assert (p["CAL_MAG2_ID"], p["CAL_MAG2_ROT"]) == (131, 2)
    assert "CAL_MAG0_XOFF" not in p
