"""A dataset at a URL has the bytes of one on disk, resumes, and is read there."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

import magbench
from recordings.loading import load_dataset
from recordings.url_path import UrlPath, place_at
from scenarios.errors import InputError
from sim.dataset_writer import generate
from tests.short import short

fsspec = pytest.importorskip("fsspec", reason="the extra `cluster` is not installed")
SCENARIO = short("tumble")
RUNS = 4


@pytest.fixture(params=["memory", "file"])
def place(request: pytest.FixtureRequest, tmp_path: Path) -> UrlPath:
    """An empty folder of fsspec's memory, and of the disk by its URL, where files are moved into place."""
    return UrlPath(f"{request.param}://{tmp_path}/cloud")


def everything(place: UrlPath) -> dict[str, bytes]:
    """The bytes of every file."""
    system, top = fsspec.core.url_to_fs(place.url)
    return {path.partition("cloud/")[2]: system.cat_file(path) for path in system.find(top)}


@pytest.mark.parametrize("options", [{}, {"split": "50/25/25", "runs_per_file": 2}], ids=["plain", "split"])
def test_a_dataset_at_a_url_is_the_one_on_disk(place: UrlPath, options: dict[str, object], tmp_path: Path) -> None:
    here = tmp_path / "here"
    generate(SCENARIO, here, runs=RUNS, **options)  # type: ignore[arg-type]
    generate(SCENARIO, place, runs=RUNS - 1, **options)  # type: ignore[arg-type]
    generate(SCENARIO, place, runs=RUNS, **options)  # type: ignore[arg-type]
    wanted = {str(path.relative_to(here)): path.read_bytes() for path in here.rglob("*") if path.is_file()}
    assert everything(place) == wanted
    told: list[str] = []
    damaged = next(name for name in wanted if name.endswith("00.parquet"))
    system, top = fsspec.core.url_to_fs((place / damaged).url)
    system.pipe_file(top, wanted[damaged][:-30])
    generate(SCENARIO, place, runs=RUNS, warn=told.append, **options)  # type: ignore[arg-type]
    assert everything(place) == wanted
    assert damaged.rpartition("/")[2] in told[0]


def test_a_dataset_at_a_url_is_read_there(place: UrlPath, tmp_path: Path) -> None:
    made = magbench.simulate(SCENARIO, tmp_path / "here", runs=RUNS, runs_per_file=2)
    generate(SCENARIO, place, runs=RUNS, runs_per_file=2)
    there = load_dataset(place)
    assert np.array_equal(there.numpy()["mag_x_nT"], made.numpy()["mag_x_nT"])
    assert np.array_equal(there[3].columns["mag_z_nT"], made[3].columns["mag_z_nT"])
    assert there.windows(length_s=1.0)[2].run == 0
    key = "effects.white_noise.std_nT.0"
    assert there.parameters[key].tolist() == made.parameters[key].tolist()


def test_a_failed_file_leaves_nothing(place: UrlPath) -> None:
    def fail() -> None:
        with (place / "run.parquet").replaced(".part") as part:
            part.write_bytes(b"half")
            raise RuntimeError

    place.mkdir()
    with pytest.raises(RuntimeError):
        fail()
    assert everything(place) == {}


def test_places_by_their_texts(tmp_path: Path) -> None:
    assert place_at(f"file://{tmp_path}") == tmp_path == place_at(str(tmp_path))
    assert place_at("s3://bucket/data/") == UrlPath("s3://bucket/data")
    with pytest.raises(InputError, match=r"nothing://bucket.*magbench\[cluster\]"):
        generate(SCENARIO, place_at("nothing://bucket/data"))
