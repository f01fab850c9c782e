"""One row a run, with the values that its file was made with."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pandas as pd
import pyarrow.parquet as pq

from recordings import read_manifest, read_run
from recordings.description.runs import flattened
from recordings.metadata import TrueParameters
from sim.dataset_writer import generate
from tests.short import short


def test_a_row_a_run_with_its_file_and_its_values(dataset: Path) -> None:
    table, manifest = pd.read_parquet(dataset / "runs.parquet"), read_manifest(dataset)
    assert table["run"].tolist() == list(range(manifest.runs))
    assert table["file"].tolist() == [file.path for file in manifest.files]
    assert table["split"].tolist() == [file.path.split("/")[1] for file in manifest.files]
    for row in table.to_dict("records"):
        recording, truth = read_run(dataset, run=row["run"])
        assert row["rows"] == len(recording)
        told = [row[f"effects.hard_iron.offset_nT.{axis}"] for axis in range(3)]
        np.testing.assert_allclose(truth.effects["hard_iron"], np.tile(told, (len(recording), 1)), atol=1e-9)
        noise_nT = [row[f"effects.white_noise.std_nT.{axis}"] for axis in range(3)]
        np.testing.assert_allclose(truth.effects["white_noise"].std(axis=0), noise_nT, rtol=0.3)
        strength_nT = np.linalg.norm([row[f"field.enu_nT.{axis}"] for axis in range(3)])
        np.testing.assert_allclose(np.linalg.norm(truth.field_nT, axis=1), strength_nT, rtol=1e-9)
        interval_s = recording.time_s[1]
        assert 0 <= row["phases.0.duration_s"] - recording.time_s[-1] < 2 * interval_s
    assert table["phases.0.duration_s"].nunique() == manifest.runs


def test_every_value_that_varies_is_a_column_and_every_column_says_what_it_is(dataset: Path) -> None:
    schema = pq.read_schema(dataset / "runs.parquet")
    varied = read_manifest(dataset).scenario["vary"]
    assert all(any(name.startswith(key) for name in schema.names) for key in varied)
    assert all(field.metadata[b"meaning"] for field in schema)


def test_parameters_are_flattened_by_component_and_an_arrays_sensor_by_sensor() -> None:
    cells = flattened(
        TrueParameters(
            field_enu_nT=[1.0, 2.0, 3.0],
            effects=[{"a": {"matrix": [[1, 2], [3, 4]], "on": True}}, {"a": {"axis": "x", "lag_s": None}}],
            effect_order=["a"],
            drawn={"field.enu_nT": [1.0, 2.0, 3.0], "vehicle.depth_m": 5},
        )
    )
    assert cells == {
        **{f"field.enu_nT.{k}": k + 1.0 for k in range(3)},
        "vehicle.depth_m": 5.0,
        **{"effects1.a.matrix.0.0": 1.0, "effects1.a.matrix.0.1": 2.0},
        **{"effects1.a.matrix.1.0": 3.0, "effects1.a.matrix.1.1": 4.0},
        **{"effects1.a.on": True, "effects2.a.axis": "x"},
    }


def test_tracking_is_there_where_a_vehicle_follows_a_path(tmp_path: Path) -> None:
    generate(short("auv-comb"), tmp_path, split="100/0/0")
    (row,) = pq.read_table(tmp_path / "runs.parquet").to_pylist()
    tracking = read_manifest(tmp_path).files[0].tracking
    assert tracking is not None
    assert (row["tracking_rms_m"], row["tracking_max_m"]) == (tracking.rms_m, tracking.max_m)
