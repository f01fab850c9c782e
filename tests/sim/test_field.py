"""The Earth's field: against published IGRF-14 values, its geometry and its limits."""

from __future__ import annotations

import datetime

import numpy as np
import pytest

from scenarios.errors import InputError
from scenarios.spec import FieldSpec
from sim.field import earth_field_enu_nT


def field_at(latitude, longitude, date, altitude=0.0):
    spec = FieldSpec(latitude_deg=latitude, longitude_deg=longitude, altitude_m=altitude, date=date)
    return earth_field_enu_nT(spec)


def test_the_standard_cases_vector_is_that_of_new_year_2018_at_sea_level():
    east, north, up = field_at(-37.66, 50.45, datetime.date(2018, 1, 1))
    np.testing.assert_allclose((north, east, -up), (12637.48, -11484.12, -32730.72), atol=0.005)


def test_a_given_vector_is_taken_as_it_is():
    assert (earth_field_enu_nT(FieldSpec(enu_nT=(1.0, 2.0, 3.0))) == [1, 2, 3]).all()


def test_the_dipole_dominates():
    """Down in the north, up in the south, north at the equator; about twice as strong at the poles."""
    date = datetime.date(2020, 6, 1)
    assert field_at(80, 0, date)[2] < -5e4
    assert field_at(-80, 0, date)[2] > 3e4
    equator = field_at(0, 100, date)
    assert equator[1] > 3.5e4
    assert abs(equator[2]) < 1.5e4


def test_the_field_falls_with_the_cube_of_the_distance():
    low, high = (np.linalg.norm(field_at(45, 10, datetime.date(2020, 1, 1), z)) for z in (0.0, 100_000.0))
    assert high / low == pytest.approx((6371 / 6471) ** 3, rel=0.01)


def test_longitude_wraps_and_the_field_changes_with_the_years():
    date = datetime.date(2015, 3, 4)
    np.testing.assert_allclose(field_at(30, -60, date), field_at(30, 300, date), rtol=1e-12)
    change = field_at(30, -60, datetime.date(2016, 3, 4)) - field_at(30, -60, date)
    assert 10 < np.linalg.norm(change) < 300


@pytest.mark.parametrize("pole", [-90, 90])
def test_the_poles_have_a_field_too(pole):
    date = datetime.date(2020, 1, 1)
    np.testing.assert_allclose(field_at(pole, 30, date), field_at(pole * (1 - 1e-7), 30, date), atol=0.01)


@pytest.mark.parametrize("date", [datetime.date(1899, 12, 31), datetime.date(2030, 1, 2)])
def test_a_date_outside_the_model_is_refused(date):
    with pytest.raises(InputError, match="1900-01-01 to 2030-01-01"):
        field_at(0, 0, date)
