"""Place and date that a log's own columns tell, whatever the columns are called."""

from __future__ import annotations

import datetime
from pathlib import Path

import numpy as np
import pytest

from recordings import read_recording
from tests.recordings.readers.swing import swing

NOON_S = 1_714_564_800
"""1 May 2024, 12:00 UTC."""


def log_of(path: Path, columns: dict[str, list[str]], first: str = "t") -> Path:
    """A table of a swing's times and field in uT, and further columns."""
    of = swing(200)
    own = {first: [f"{t:.3f}" for t in of.time_s]} if first not in columns else {}
    own |= {name: [f"{v:.4f}" for v in part / 1e3] for name, part in zip(("mx", "my", "mz"), of.mag_nT.T, strict=True)}
    every = own | columns
    rows = [",".join(row) for row in zip(*every.values(), strict=True)]
    path.write_text("\n".join([",".join(every), *rows]) + "\n", encoding="utf-8")
    return path


def fixes(*values: str) -> list[list[str]]:
    """Three quarters of the rows have a fix."""
    return [["0"] * 50 + [value] * 150 for value in values]


@pytest.mark.parametrize(
    ("names", "values", "place"),
    [
        (("Latitude", "Longitude", "Altitude (m)"), ("47.37", "8.54", "480.5"), (47.37, 8.54, 480.5)),
        (("gps_lat", "gps_lon", "gps_alt_ft"), ("-33.9", "151.2", "100"), (-33.9, 151.2, 30.48)),
        (("GPS.lat", "GPS.lng", "other_alt"), ("47.37", "8.54", "480.5"), (47.37, 8.54, 0.0)),
        (("lat", "lon", "alt"), ("473700000", "85400000", "480500"), (47.37, 8.54, 480.5)),
        (("lat_rad", "lon_rad", "alt"), ("0.8267624", "0.1490511", "480.5"), (47.37, 8.54, 480.5)),
        (("home_lat", "home_lon", "alt"), ("47.37", "8.54", "480.5"), None),
        (("lat", "speed", "alt"), ("47.37", "8.54", "480.5"), None),
    ],
)
def test_place_of_columns(
    names: tuple[str, ...], values: tuple[str, ...], place: tuple[float, ...] | None, tmp_path: Path
) -> None:
    path = log_of(tmp_path / "log.csv", dict(zip(names, fixes(*values), strict=True)))
    found = read_recording(path).origin.place
    assert found == (place and pytest.approx(place, abs=1e-4))


def stamps(form: str) -> dict[str, list[str]]:
    """A column of times, as different loggers write them."""
    times = NOON_S + np.arange(200) * 0.05
    if form == "unix":
        return {"time": [f"{t:.3f}" for t in times]}
    if form == "ms":
        return {"Device_Timestamp_Unix_CAL": [f"{1e3 * t:.0f}" for t in times]}
    clock = [datetime.datetime.fromtimestamp(t, datetime.UTC) for t in times]
    if form == "iso":
        return {"time": [f"{t:%Y-%m-%dT%H:%M:%S.%f}Z" for t in clock]}
    return {"t": [f"{t:.3f}" for t in times - NOON_S], "GPS:dateTimeStamp": [f"{t:%Y-%m-%d %H:%M:%S}" for t in clock]}


@pytest.mark.parametrize("form", ["unix", "ms", "iso", "beside"])
def test_date_of_columns(form: str, tmp_path: Path) -> None:
    given = stamps(form)
    found = read_recording(log_of(tmp_path / "log.csv", given, next(iter(given))))
    assert found.origin.date == datetime.date(2024, 5, 1)
    assert found.origin.timed
    np.testing.assert_allclose(np.diff(found.time_s), 0.05, atol=1e-3)


def test_a_clock_that_was_never_set_tells_no_date(tmp_path: Path) -> None:
    assert read_recording(log_of(tmp_path / "log.csv", {})).origin.date is None
