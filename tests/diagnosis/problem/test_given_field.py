"""A log flown over hundreds of kilometres: the field changes along its latitude and longitude."""

from __future__ import annotations

import datetime
from dataclasses import replace

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from diagnosis.decision.remarks import reference_remarks
from diagnosis.problem.formulation import pose_model
from diagnosis.problem.known import FieldTrack
from diagnosis.workflow import diagnose
from recordings import Recording
from recordings.channels import ALTITUDE, LATITUDE, LONGITUDE
from scenarios.errors import InputError
from scenarios.spec import FieldSpec
from sim.field import earth_field_along, earth_field_enu_nT
from sim.scenario import ModelSpec
from tests.diagnosis.synthetic import COSTLY, NOISE_NT, recording, without_attitude

DATE = datetime.date(2024, 5, 27)
FIELD = FieldSpec(latitude_deg=12.0, longitude_deg=85.0, date=DATE)
PLACE = {"latitude_deg": 12.0, "longitude_deg": 85.0, "date": DATE.isoformat()}


def _flown(*, hidden_nT_A: float = 0.0) -> Recording:
    """The synthetic turns, from 12 to 16 degrees north in the field of one date, with a current's field."""
    given = recording(1500, noise_nT=0.0)
    part = given.time_s / given.time_s[-1]
    places = np.column_stack([12 + 4 * part, 85 + 2 * part, np.zeros(len(part))])
    along = earth_field_along(places, DATE)
    assert given.att_q is not None
    assert given.current_A is not None
    noise = NOISE_NT * np.random.default_rng(1).normal(size=(len(given), 3))
    mag_nT = Rotation.from_quat(given.att_q[:, [1, 2, 3, 0]]).inv().apply(along) + noise
    mag_nT += hidden_nT_A * given.current_A[:, :1] * [1.0, -0.5, 0.7]
    channels = {LATITUDE: places[:, 0], LONGITUDE: places[:, 1], ALTITUDE: places[:, 2]}
    return replace(given, mag_nT=mag_nT, channels=channels, temperature_degC=None)


def _model() -> ModelSpec:
    return ModelSpec.model_validate({"field": PLACE})


def test_many_places_at_once_are_the_model_at_each() -> None:
    places = np.array([[54.0, 10.0, 0.0], [-33.0, 151.0, 5000.0]])
    singly = [
        earth_field_enu_nT(FieldSpec(latitude_deg=a, longitude_deg=b, altitude_m=c, date=DATE)) for a, b, c in places
    ]
    assert earth_field_along(places, DATE) == pytest.approx(np.array(singly))


def test_the_fields_rate_has_what_changes_on_the_way() -> None:
    """A delay of a satellite's magnetometer shows in it where its turn looks like iron."""
    given = _flown()
    state = pose_model(given, _model(), None, None).state
    turned = np.cross(state.rate_rad_s, state.field_nT)
    on_the_way = np.einsum("nij,nj->ni", state.R_wb, state.field_rate_nT_s + turned)
    along = earth_field_along(np.column_stack([given.channels[key] for key in (LATITUDE, LONGITUDE, ALTITUDE)]), DATE)
    assert on_the_way == pytest.approx(np.gradient(along, given.time_s, axis=0), rel=0.02, abs=0.1)
    assert np.abs(on_the_way).max() > 10


@pytest.mark.parametrize("attitude", [True, False])
def test_the_field_changes_along_the_track(attitude: bool) -> None:
    given = _flown() if attitude else without_attitude(_flown())
    problem = pose_model(given, _model(), None, None)
    assert np.sqrt((problem.target**2).mean()) < 1.1
    assert problem.sigma_nT == pytest.approx(NOISE_NT, rel=0.1)
    bare = replace(given, channels={})
    assert np.sqrt((pose_model(bare, _model(), None, None).target ** 2).mean()) > 20


def test_an_effect_is_named_beside_the_track() -> None:
    found = diagnose(_flown(hidden_nT_A=4.0), _model(), fitted_base=True, without=COSTLY)
    assert [one.name for one in found.named] == ["motor_current"]


@pytest.mark.slow
def test_a_long_path_without_its_place_is_told_first() -> None:
    given = _flown()
    north_m = 111e3 * (given.channels["latitude_deg"] - 12)
    far = replace(given, channels={}, current_A=None, pos_enu_m=np.column_stack([0 * north_m, north_m, 0 * north_m]))
    found = diagnose(far, _model(), fitted_base=True)
    assert "the Earth's field changes" in found.sentence
    assert any("latitude_deg" in line for line in found.advice)


def test_rows_without_a_place_are_bridged() -> None:
    given = _flown()
    gaps = given.channels["latitude_deg"].copy()
    gaps[:200] = gaps[700:720] = np.nan
    whole, bridged = (
        FieldTrack.of(given, FIELD),
        FieldTrack.of(replace(given, channels=given.channels | {"latitude_deg": gaps}), FIELD),
    )
    assert whole is not None
    assert bridged is not None
    shift = whole.change_enu_nT - bridged.change_enu_nT
    assert np.ptp(shift[200:], axis=0).max() < 1.0
    none = replace(given, channels=given.channels | {"latitude_deg": np.full(len(given), np.nan)})
    assert FieldTrack.of(none, FIELD) is None


def test_an_orbit_is_followed() -> None:
    """Three turns in three hours at 700 km, every second: what lies between the places that are asked is 1 nT off."""
    turn = np.linspace(0, 6 * np.pi, 10_800)
    places = np.column_stack([80 * np.sin(turn), (np.degrees(turn) / 2) % 360, np.full(len(turn), 7e5)])
    channels = dict(zip(("latitude_deg", "longitude_deg", "altitude_m"), places.T, strict=True))
    mag_nT = np.ones((len(turn), 3))
    track = FieldTrack.of(Recording(np.arange(len(turn), dtype=float), mag_nT, channels=channels), FIELD)
    assert track is not None
    here = earth_field_along(places[[len(turn) // 2]], DATE)  # a row away it is 97 nT more
    assert track.field_enu_nT == pytest.approx(here[0])
    at = slice(37, None, 500)
    assert track.change_enu_nT[at] == pytest.approx(earth_field_along(places[at], DATE) - here, abs=1.0)


def _risen(*, noise_nT: float = NOISE_NT) -> Recording:
    """The synthetic turns of a balloon that rises from 200 m to 9 km in the field of the model's own place."""
    given = recording(1500, noise_nT=0.0)
    height_m = 200 + 8800 * given.time_s / given.time_s[-1]
    along = earth_field_along(np.column_stack([np.full(1500, 12.0), np.full(1500, 85.0), height_m]), DATE)
    assert given.att_q is not None
    noise = noise_nT * np.random.default_rng(2).normal(size=(1500, 3))
    mag_nT = Rotation.from_quat(given.att_q[:, [1, 2, 3, 0]]).inv().apply(along) + noise
    bare = {"temperature_degC": None, "pos_enu_m": None, "current_A": None}
    return replace(given, mag_nT=mag_nT, channels={"altitude_m": height_m}, **bare)


@pytest.mark.parametrize("attitude", [True, False])
def test_a_balloons_field_falls_with_its_height(attitude: bool) -> None:
    """A log with its altitude alone, beside a model that is given by its place."""
    given = _risen() if attitude else without_attitude(_risen())
    assert np.sqrt((pose_model(given, _model(), None, None).target ** 2).mean()) < 1.1
    bare = replace(given, channels={})
    assert np.sqrt((pose_model(bare, _model(), None, None).target ** 2).mean()) > 5
    track = FieldTrack.of(given, FIELD)
    assert track is not None
    assert track.field_enu_nT == pytest.approx(earth_field_along(np.array([[12.0, 85.0, 0.0]]), DATE)[0])


def test_a_height_beside_one_vector_is_told_first() -> None:
    vector = tuple(earth_field_along(np.array([[12.0, 85.0, 200.0]]), DATE)[0])
    found = diagnose(_risen(), ModelSpec.model_validate({"field": {"enu_nT": vector}}), fitted_base=True)
    assert "8.80 km of height" in found.sentence
    assert any("altitude_m" in line for line in found.advice)
    level = replace(_risen(), channels={"altitude_m": np.full(1500, 200.0)})
    assert not any(reference_remarks(replace(found, problem=replace(found.problem, recording=level))))


def test_what_is_no_place_is_refused() -> None:
    given = _flown()
    wrong = replace(given, channels=given.channels | {"latitude_deg": given.channels["latitude_deg"] + 90})
    with pytest.raises(InputError, match="latitude_deg"):
        FieldTrack.of(wrong, None)
    assert FieldTrack.of(recording(), FIELD) is None
