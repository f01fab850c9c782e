"""Small logs of people: the status and its cause, in counts and in nT."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from calib import Reference, get
from recordings import Recording

CASES = Path(__file__).parents[1] / "recordings/cases"
TRUTH_NT = np.array([12_000.0, -8_000.0, 25_000.0])
GAIN = 6842.0 / 1e5
"""Counts a nT."""


def log(name: str) -> Recording:
    """Time and three columns of a file with a line of names."""
    values = np.genfromtxt(CASES / f"{name}.csv", delimiter=",", skip_header=1)
    return Recording(values[:, 0] / (1e3 if name.startswith("raw") else 1.0), np.ascontiguousarray(values[:, 1:4]))


@pytest.mark.parametrize("strength_nT", [30_000.0, 48_000.0])
@pytest.mark.parametrize("name", ["sphere", "ellipsoid", "twostep", "ml_newton", "ml_geometric", "pso"])
def test_tilts_of_22_degrees_are_too_few_in_counts_and_in_nanotesla(name, strength_nT):
    for file in ("partial_counts", "partial_nT"):
        assert get(name).fit(log(file), Reference(strength_nT)).status.kind == "unobservable"


@pytest.mark.parametrize("name", ["ellipsoid", "twostep", "ml_newton", "ml_geometric", "pso", "ukf"])
def test_counts_of_a_whole_sphere_give_the_offset_in_counts(name):
    fit = get(name).fit(log("raw_lis3mdl"), Reference(48_000.0))
    assert fit.status.kind == "ok"
    error = fit.offset_nT - GAIN * TRUTH_NT
    assert np.abs(error / np.sqrt(np.diag(fit.offset_covariance_nT2))).max() < 3.5


def test_a_sphere_off_by_497_nanotesla_in_counts_is_doubted():
    status = get("sphere").fit(log("raw_lis3mdl"), Reference(48_000.0)).status
    assert status.kind == "unobservable"
    assert "not on a sphere" in status.reason


@pytest.mark.parametrize("name", ["ellipsoid", "twostep", "ml_newton", "ml_geometric"])
def test_half_a_sphere_of_a_nonlinear_sensor_is_doubted_by_its_cause(name):
    fit = get(name).fit(log("half_sphere_nonlinear"), Reference(48_000.0))
    assert fit.status.kind == "unobservable"
    assert "nonlinear characteristic" in fit.status.reason
    assert np.abs((fit.offset_nT - TRUTH_NT) / np.sqrt(np.diag(fit.offset_covariance_nT2))).max() < 2.0


@pytest.mark.parametrize("name", ["ellipsoid", "twostep", "ml_newton", "ml_geometric"])
@pytest.mark.parametrize("file", ["poses24", "poses40"])
def test_a_few_poses_are_enough(name, file):
    fit = get(name).fit(log(file), Reference(48_000.0))
    assert fit.status.kind == "ok"
    assert np.abs((fit.offset_nT - TRUTH_NT) / np.sqrt(np.diag(fit.offset_covariance_nT2))).max() < 3.0
