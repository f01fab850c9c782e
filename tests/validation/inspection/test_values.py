"""Faults of the values, put in at known rows."""

from __future__ import annotations

import numpy as np
import pytest

from scenarios.arrays import Array
from tests.validation.inspection.recordings import RATE_HZ, log_of, noise, one, rounded, sensor_data, turning
from validation.inspection.finding import Finding
from validation.inspection.values import missing_finding, value_findings

SAMPLES = 6000
TIME_S, FIELD_NT = turning(SAMPLES)
STD_NT = 5.0
MAG_NT = FIELD_NT + noise(SAMPLES, STD_NT)


def findings(mag_nT: Array, time_s: Array = TIME_S) -> list[Finding]:
    return value_findings(sensor_data(time_s, mag_nT))


def test_a_sound_series_has_no_fault() -> None:
    found = findings(MAG_NT)
    assert {finding.level for finding in found} == {"ok"}
    assert [finding.name for finding in found] == ["step", "full_scale", "frozen", "spikes"]


def test_empty_cells_are_counted_by_column() -> None:
    mag_nT = MAG_NT.copy()
    mag_nT[:3, 1] = np.nan
    mag_nT[7, 2] = np.inf
    found = missing_finding(log_of(TIME_S, mag_nT, temperature_degC=np.full(SAMPLES, np.nan)))
    assert found.value == {"mag_y_nT": 3, "mag_z_nT": 1, "temperature_degC": SAMPLES}
    assert found.level == "warning"
    assert missing_finding(log_of(TIME_S, MAG_NT)).text == "No cell is empty."


def test_a_constant_axis() -> None:
    mag_nT = MAG_NT.copy()
    mag_nT[:, 1] = 300.0
    assert one(findings(mag_nT), "constant").text.startswith("Axis y is constant")


@pytest.mark.parametrize(("step", "level"), [(0.25, "ok"), (5.0, "ok"), (40.0, "note")])
def test_the_least_significant_bit_against_the_noise(step: float, level: str) -> None:
    """The noise that the differences show includes the rounding's: sqrt(5^2 + q^2 / 12)."""
    found = one(findings(rounded(MAG_NT, step)), "step")
    assert found.value == pytest.approx([step] * 3)
    assert found.level == level
    ratio = step / np.sqrt(STD_NT**2 + step**2 / 12)
    said = float(found.text.split(", ")[-1].split()[0])
    assert said == pytest.approx(ratio, rel=0.1)


def test_values_beside_the_lattice_are_a_share() -> None:
    mag_nT = rounded(MAG_NT, 40.0)
    mag_nT[::50] += 12.0
    assert "2 % of the values are not multiples" in one(findings(mag_nT), "step").text


def test_a_log_with_few_digits() -> None:
    mag_nT = np.vectorize(lambda v: float(f"{v:.3g}"))(MAG_NT * 0.1)
    assert "fixed number of digits" in one(findings(mag_nT * 10), "step").text


def test_averaged_codes_prefer_the_converters_own() -> None:
    """Every second value is a mean of two of the converter's: half of these lie between its codes."""
    codes = np.round((20_000 + 2000 * np.sin(TIME_S)[:, None] + noise(SAMPLES, 60.0)) / 30.0)
    codes[1::2] = (codes[1::2] + codes[::2]) / 2
    found = one(findings(30.0 * codes), "preferred_codes")
    assert found.value == pytest.approx([0.25] * 3, abs=0.02)
    assert "converter's step is perhaps 30" in found.text
    assert "preferred_codes" not in {finding.name for finding in findings(15.0 * np.round(MAG_NT / 15.0))}


def test_full_scale_at_its_level() -> None:
    found = one(findings(rounded(np.clip(MAG_NT, -1e6, 45_000), 15.0)), "full_scale")
    assert {place["level_nT"] for place in found.value} == {45_000.0}
    assert {place["side"] for place in found.value} == {"high"}
    assert "Cut off at full scale" in found.text


def test_a_frozen_stretch_by_time_and_row() -> None:
    mag_nT = MAG_NT.copy()
    mag_nT[4000:4050] = mag_nT[4000]
    found = one(findings(mag_nT), "frozen")
    assert found.value == [{"at_s": pytest.approx(4000 / RATE_HZ), "samples": 50, "row": 4001}]
    assert found.text == "Frozen 1 time, 50 samples together; the longest, 1 s, begins at 80 s."


def test_spikes_are_counted_by_axis() -> None:
    mag_nT = MAG_NT.copy()
    mag_nT[[500, 1500, 2500], [0, 0, 2]] += 400.0
    found = one(findings(mag_nT), "spikes")
    assert found.value == {"x": 2, "y": 0, "z": 1}
    assert "the first at 10 s" in found.text


def test_the_samples_told_are_those_that_a_calibration_leaves_out() -> None:
    """A stuck axis that the screening takes out leaves no spikes at its ends."""
    mag_nT = MAG_NT.copy()
    mag_nT[3000:3400, 2] = mag_nT[3000, 2]
    assert one(findings(mag_nT), "spikes").value == {"x": 0, "y": 0, "z": 0}
    mag_nT[[500, 1500], [0, 1]] += 400.0
    found = one(findings(mag_nT), "spikes")
    assert found.value == {"x": 1, "y": 1, "z": 0}
    assert "a calibration leaves them out" in found.text


def test_nothing_is_said_of_neighbours_that_are_none() -> None:
    """Every second interval a gap."""
    time_s = TIME_S + np.repeat(np.arange(SAMPLES / 4), 4)
    assert "spikes" not in {finding.name for finding in findings(MAG_NT, time_s)}


def test_too_few_rows() -> None:
    assert findings(MAG_NT[:2], TIME_S[:2]) == []
