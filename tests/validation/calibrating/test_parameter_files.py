"""Calibrations of other programs are read back: round trips of our exports, and files with answers worked by hand."""

from __future__ import annotations

import json
from contextlib import suppress
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

import calib
from calib import Calibration, Status
from calib.input_terms import InputTerm
from scenarios.errors import InputError
from validation.calibrating.export import exported
from validation.calibrating.output_unit import OutputUnit
from validation.calibrating.parameter_files import calibrations_of, chosen, read_parameter_file
from validation.calibrating.parameter_files.file_format import FileScale

MATRIX = np.array([[0.95, 0.02, -0.01], [0.02, 1.05, 0.03], [-0.01, 0.03, 1.01]])
OFFSET_NT = np.array([1200.0, -800.0, 2000.0])
GOOD = Calibration(name="ellipsoid", status=Status("ok"), offset_nT=OFFSET_NT, matrix=MATRIX)
MICROTESLA = FileScale(1e3)


def read(text: str, scale: FileScale = FileScale()) -> dict[str, Calibration]:  # noqa: B008 a frozen value
    return calibrations_of(text, "old", scale)


def only(text: str, scale: FileScale = FileScale()) -> Calibration:  # noqa: B008
    (found,) = read(text, scale).values()
    return found


def agrees(found: Calibration, offset_nT: object, matrix: object, atol_nT: float = 1e-6) -> None:
    np.testing.assert_allclose(found.offset_nT, offset_nT, atol=atol_nT)
    np.testing.assert_allclose(found.matrix, matrix, atol=1e-6)
    assert found.status.kind == "ok"


@pytest.mark.parametrize("form", ["c", "px4", "ardupilot", "ros"])
def test_an_export_is_read_back(form: str) -> None:
    agrees(only(exported(GOOD, form)[1]), OFFSET_NT, MATRIX, atol_nT=0.01)


@pytest.mark.parametrize("unit", [OutputUnit("uT", "uT", (1e3,) * 3), OutputUnit("counts", "nT", (14.6,) * 3)])
def test_a_c_header_of_another_unit_is_read_back(unit: OutputUnit) -> None:
    agrees(only(exported(GOOD, "c", unit=unit)[1], FileScale(14.6)), OFFSET_NT, MATRIX, atol_nT=0.01)


def test_a_calibration_json_keeps_its_covariance(tmp_path: Path) -> None:
    claimed = Calibration(
        name="sphere",
        status=Status("ok"),
        offset_nT=OFFSET_NT,
        covariance=np.diag([4.0, 9.0, 1.0]),
        covariance_names=calib.result.OFFSET_NAMES,
    )
    (tmp_path / "old.json").write_text(json.dumps({"sphere": calib.to_dict(claimed)}))
    found = read_parameter_file(tmp_path / "old.json")["sphere"]
    np.testing.assert_array_equal(found.covariance, np.diag([4.0, 9.0, 1.0]))


QGROUNDCONTROL = """# Onboard parameters for Vehicle 1
#
# Vehicle-Id Component-Id Name Value Type
1\t1\tCAL_MAG0_ID\t396825\t6
1\t1\tCAL_MAG0_ROT\t2\t6
1\t1\tCAL_MAG0_XOFF\t0.012\t9
1\t1\tCAL_MAG0_YOFF\t-0.034\t9
1\t1\tCAL_MAG0_ZOFF\t0.056\t9
1\t1\tCAL_MAG0_XSCALE\t1.10\t9
1\t1\tCAL_MAG0_YSCALE\t0.90\t9
1\t1\tCAL_MAG0_ZSCALE\t1.05\t9
1\t1\tCAL_MAG0_XODIAG\t0.02\t9
1\t1\tCAL_MAG1_ID\t0\t6
1\t1\tCAL_MAG1_XOFF\t0.0\t9
1\t1\tCAL_MAG1_YOFF\t0.0\t9
1\t1\tCAL_MAG1_ZOFF\t0.0\t9
"""


def test_px4_s_sensor_axes_are_turned_to_the_body() -> None:
    """Yaw 90: forward is the sensor's -y, right its x; left and up change sign: (3400, -1200, -5600) nT."""
    found = read(QGROUNDCONTROL)
    assert list(found) == ["0"]
    matrix = [[0.90, 0.02, 0.0], [0.02, 1.10, 0.0], [0.0, 0.0, 1.05]]
    agrees(found["0"], [3400.0, -1200.0, -5600.0], matrix)


@pytest.mark.parametrize(
    "text",
    [
        "param set CAL_MAG0_XOFF 0.012\nparam set CAL_MAG0_YOFF 0\nparam set CAL_MAG0_ZOFF 0\n",
        "CAL_MAG0_XOFF,0.012\nCAL_MAG0_YOFF,0.0\nCAL_MAG0_ZOFF,0.0\n",
        "Symbols: x = used, + = saved, * = unsaved\nx + CAL_MAG0_XOFF [101,201] : 0.0120\n"
        "x   CAL_MAG0_YOFF [102,202] : 0.0000\nx * CAL_MAG0_ZOFF [103,203] : 0.0000\n",
    ],
)
def test_px4_without_a_mounting_says_what_was_assumed(text: str) -> None:
    agrees(only(text), [1200.0, 0.0, 0.0], np.eye(3))
    assert "CAL_MAG0_ROT" in only(text).status.reason


def test_ardupilot_adds_its_offset_and_scales_first() -> None:
    """Field = M s (raw + o): s 1.2, M diag (1, 0.9, 1.1); o = (-12, 34, 56) mG is b = (1200, 3400, 5600) nT in FLU."""
    text = "COMPASS_OFS_X -12\nCOMPASS_OFS_Y 34\nCOMPASS_OFS_Z 56\nCOMPASS_SCALE 1.2\n"
    text += (
        "COMPASS_DIA_X 1\nCOMPASS_DIA_Y 0.9\nCOMPASS_DIA_Z 1.1\nCOMPASS_OFS2_X 5\nCOMPASS_OFS2_Y 0\nCOMPASS_OFS2_Z 0\n"
    )
    found = read(text)
    agrees(found["1"], [1200.0, 3400.0, 5600.0], np.diag([1.2, 1.08, 1.32]))
    agrees(found["2"], [-500.0, 0.0, 0.0], np.eye(3))


def test_ardupilot_adds_its_motors_field_last() -> None:
    """MOT (10, -20, 30) mG an ampere, M s = 1.2: measured -(1000, -2000, 3000) / 1.2 nT/A in FRD."""
    text = "COMPASS_OFS_X -12\nCOMPASS_OFS_Y 0\nCOMPASS_OFS_Z 0\nCOMPASS_SCALE 1.2\nCOMPASS_MOTCT 2\n"
    text += "COMPASS_MOT_X 10\nCOMPASS_MOT_Y -20\nCOMPASS_MOT_Z 30\nCOMPASS_OFS2_X 5\nCOMPASS_OFS2_Y 0\n"
    text += "COMPASS_OFS2_Z 0\nCOMPASS_MOT2_X 12\nCOMPASS_MOT2_Y 0\nCOMPASS_MOT2_Z 0\n"
    found = read(text)
    (first,), (second,) = found["1"].inputs, found["2"].inputs
    np.testing.assert_allclose(first.gain_nT, np.array([-1000.0, -2000.0, 3000.0]) / 1.2)
    np.testing.assert_allclose(second.gain_nT, [-1200.0, 0.0, 0.0])
    assert first.channel == "current_sum_A"
    (throttle,) = read(text.replace("MOTCT 2", "MOTCT 1"))["1"].inputs
    assert throttle.channel == "throttle"
    off = read(text.replace("MOTCT 2", "MOTCT 0"))["1"]
    assert off.inputs == ()
    assert "switched off" in off.status.reason


def test_px4_adds_its_motors_field_first() -> None:
    """COMP x 0.5 G/kA in the sensor's axes: 50 nT/A of -x, which yaw 90 turns to the right: +50 nT/A along left."""
    text = QGROUNDCONTROL + "1\t1\tCAL_MAG0_XCOMP\t0.5\t9\n1\t1\tCAL_MAG_COMP_TYP\t2\t6\n"
    (term,) = read(text)["0"].inputs
    assert term.channel == "current_sum_A"
    np.testing.assert_allclose(term.gain_nT, [0.0, 50.0, 0.0], atol=1e-9)
    (throttle,) = read(text.replace("COMP_TYP\t2", "COMP_TYP\t1"))["0"].inputs
    np.testing.assert_allclose(throttle.gain_nT, [0.0, 50_000.0, 0.0], atol=1e-6)


@pytest.mark.parametrize("form", ["px4", "ardupilot"])
def test_an_exported_motor_term_is_read_back(form: str) -> None:
    term = InputTerm("current_sum_A", np.array([30.0, -20.0, 10.0]))
    (found,) = only(exported(replace(GOOD, inputs=(term,)), form)[1]).inputs
    assert found.channel == term.channel
    np.testing.assert_allclose(found.gain_nT, term.gain_nT, atol=0.01)


def test_betaflight_is_in_counts_of_the_body_s_axes() -> None:
    agrees(only("# diff\nset mag_calibration = 35,-130,-75\n", FileScale(10.0)), [350.0, -1300.0, -750.0], np.eye(3))
    with pytest.raises(InputError, match="tells no unit"):
        only("set mag_calibration = 35,-130,-75\n")


def test_inav_s_gain_is_a_scale_of_its_own_axes() -> None:
    """CW90FLIP: forward is the sensor's y, left its x, up its -z."""
    text = "set align_mag = CW90FLIP\nset magzero_x = -143\nset magzero_y = 757\nset magzero_z = 10\n"
    text += "set maggain_x = 2048\nset maggain_y = 1024\nset maggain_z = 512\n"
    agrees(only(text, FileScale(2.0)), [1514.0, -286.0, -20.0], np.diag([1.0, 0.5, 2.0]))


PRINTED = """Magnetic Calibration:   (1.9% fit error)
      1.20    1.010  0.020  0.000
     -3.40    0.020  0.990  0.000
      5.60    0.000  0.000  1.000
"""
SHOWN = "Magnetic Offset\n1.20\n-3.40\n5.60\nMagnetic Mapping\n"
SHOWN += "+1.010 +0.020 +0.000\n+0.020 +0.990 +0.000\n+0.000 +0.000 +1.000\n"
IN_C = (
    "float mag_offsets[3] = { 1.20F, -3.40F, 5.60F };\nfloat mag_softiron_matrix[3][3] = { { 1.010, 0.020, 0.000 },\n"
)
IN_C += "  { 0.020, 0.990, 0.000 },\n  { 0.000, 0.000, 1.000 } };\nfloat mag_field_strength = 50.0F;\n"


@pytest.mark.parametrize("text", [PRINTED, SHOWN, IN_C])
def test_motioncal_is_in_microtesla(text: str) -> None:
    agrees(only(text), [1200.0, -3400.0, 5600.0], [[1.01, 0.02, 0.0], [0.02, 0.99, 0.0], [0.0, 0.0, 1.0]])


MAGNETO = [
    "Combined bias (b):\n1.20\n-3.40\n5.60\n"
    "Correction for combined scale factors, misalignments and soft iron (A^-1):\n"
    "1.5 0.02 0\n0.02 1.4 0\n0 0 1.6\n",
    " float M_B[3]\n {   1.20,   -3.40,    5.60};\n float M_Ainv[3][3]\n  {{  1.5, 0.02,  0},\n  { 0.02,  1.4, 0},\n"
    "  {  0, 0,  1.6}};\n float A_B[3]{  723.48,  529.34,-2894.69}; // accelerometer\n",
    "A = np.array([[1.5, 0.02, 0.0],  # 'A^-1' matrix from Magneto\n [0.02, 1.4, 0.0],\n [0.0, 0.0, 1.6]])\n"
    "# 'Combined bias (b)' vector from Magneto\nb = np.array([1.20, -3.40, 5.60])\n",
    "const float magn_ellipsoid_center[3] = {1.20, -3.40, 5.60};\n"
    "const float magn_ellipsoid_transform[3][3] = {{1.5, 0.02, 0}, {0.02, 1.4, 0}, {0, 0, 1.6}};\n",
]


@pytest.mark.parametrize("text", MAGNETO)
def test_magneto_is_read_as_people_paste_it(text: str) -> None:
    agrees(only(text, MICROTESLA), [1200.0, -3400.0, 5600.0], [[1.5, 0.02, 0], [0.02, 1.4, 0], [0, 0, 1.6]])


def test_a_matrix_to_a_unit_sphere_needs_the_length_and_the_field() -> None:
    """50,000 nT on a sphere of radius 1 from microtesla: a gain of 0.02 is 0.02 x 50,000 / 1000 = 1."""
    text = "float M_B[3] {1, 2, 3};\nfloat M_Ainv[3][3] {{0.02,0,0},{0,0.02,0},{0,0,0.022}};\n"
    with pytest.raises(InputError, match=r"scales by 0.02.*--old-norm"):
        only(text, MICROTESLA)
    agrees(only(text, FileScale(1e3, 1.0, 50_000.0)), [1e3, 2e3, 3e3], np.diag([1.0, 1.0, 1.1]))


def test_imu_calib_subtracts_after_the_matrix() -> None:
    text = "SM:\n- 2.0\n- 0.0\n- 0.0\n- 0.0\n- 1.0\n- 0.0\n- 0.0\n- 0.0\n- 0.5\nbias: [3.0, 4.0, 5.0]\n"
    agrees(only(text, MICROTESLA), [1500.0, 4000.0, 10_000.0], np.diag([2.0, 1.0, 0.5]))


@pytest.mark.parametrize(
    ("text", "what"),
    [
        ("", "no calibration"),
        ("hello\n1 2 3\n", "no calibration"),
        ("COMPASS_OFS_X,1\nCAL_MAG0_XOFF,1\n", "PX4 and ArduPilot"),
        ("COMPASS_OFS_X,12\nCOMPASS_OFS_Y,abc\nCOMPASS_OFS_Z,3\n", "COMPASS_OFS_Y: 'abc' is not a number"),
        ("COMPASS_OFS_X,12\nCOMPASS_OFS_Y,nan\nCOMPASS_OFS_Z,3\n", "not a number"),
        ("COMPASS_OFS_X,12\nCOMPASS_OFS_Y,1\n", "COMPASS_OFS_Z is missing"),
        ("COMPASS_OFS_X,12\nCOMPASS_OFS_X,13\nCOMPASS_OFS_Y,1\nCOMPASS_OFS_Z,1\n", "COMPASS_OFS_X has several values"),
        (
            "COMPASS_OFS_X,1\nCOMPASS_OFS_Y,1\nCOMPASS_OFS_Z,1\nCOMPASS_MOTCT,2\nCOMPASS_MOT_X,1\nCOMPASS_MOT_Y,0\n"
            "COMPASS_MOT_Z,0\nCOMPASS_DIA_X,1\nCOMPASS_DIA_Y,0\nCOMPASS_DIA_Z,1\n",
            "singular",
        ),
        ("set mag_calibration = 35,-130\n", "no three numbers"),
        ("set mag_calibration = 0,0,0\n", "not calibrated"),
        ("set magzero_x = 3\nset align_mag = CW45\n", "no alignment"),
        ("set magzero_x = 3\nset maggain_y = 0\n", "maggain is 0"),
        (PRINTED.replace("0.990", "0.99O"), "missing or damaged"),
        ("Combined bias (b): 1 2 3\n", "matrix is missing"),
        (MAGNETO[1] + "float M_B[3] {1, 2, 3};", "several calibrations"),
        ("SM: [1,0,0,0,1,0,0,0,0]\nbias: [1,2,3]\n", "singular"),
        ("static const float MAG_OFFSET_NT[3] = {1, 2};", "damaged"),
        ("magnetometer_calibration:\n  offset_T: [1e-6, 0, 0]\n  matrix:\n    - [1, 0, 0]\n", "damaged"),
        (QGROUNDCONTROL.replace("ROT\t2", "ROT\t77"), "no mounting of number 77"),
        ("{", "not JSON"),
        ('{"a": {"status": "unobservable", "reason": "flat"}}', "no calibration in it has an estimate"),
        ("a" * 2_000_000, "too long"),
    ],
)
def test_a_damaged_or_foreign_file_is_one_line(text: str, what: str, tmp_path: Path) -> None:
    (tmp_path / "old").write_text(text)
    with pytest.raises(InputError, match=what) as told:
        read_parameter_file(tmp_path / "old", MICROTESLA)
    assert "\n" not in str(told.value)


def test_random_damage_is_a_calibration_or_one_line() -> None:
    rng = np.random.default_rng(0)
    texts = [QGROUNDCONTROL, PRINTED, IN_C, *MAGNETO, *(exported(GOOD, form)[1] for form in ("c", "ros", "ardupilot"))]
    for text in texts:
        for _ in range(30):
            cut, at = rng.integers(len(text), size=2)
            damaged = text[:at] + chr(rng.integers(32, 127)) + text[at + 1 :]
            with suppress(InputError):
                found = read(damaged[: max(cut, len(text) // 2)], MICROTESLA)
                assert all(np.isfinite(one.matrix).all() for one in found.values())


def test_the_unit_is_a_word_or_the_size_of_a_count() -> None:
    assert FileScale.stated("uT").nT == 1e3
    assert FileScale.stated("counts=14.6").nT == 14.6
    for wrong in ("furlong", "counts=0", "counts=x"):
        with pytest.raises(InputError, match="is no unit"):
            FileScale.stated(wrong)


def test_one_compass_is_chosen() -> None:
    found = {"1": GOOD, "2": GOOD}
    assert chosen(found, None, "old") == "1"
    assert chosen(found, None, "old", ["7", "2"]) == "2"
    failed = replace(GOOD, status=Status("unobservable", "level"))
    assert chosen({"1": failed, "2": GOOD}, None, "old") == "2"
    assert chosen({"1": failed, "2": failed}, None, "old") == "1"
    with pytest.raises(InputError, match="choose among 1, 2"):
        chosen(found, "3", "old")
