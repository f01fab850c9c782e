"""Compiled loops are kept where that can be done, and the program starts where it cannot."""

from __future__ import annotations

import os
import tempfile
from pathlib import Path

import numba
import pytest

from scenarios import numba_cache


@pytest.fixture(autouse=True)
def undecided(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    monkeypatch.setenv("NUMBA_CACHE_DIR", "restored afterwards")
    monkeypatch.delenv("NUMBA_CACHE_DIR")
    monkeypatch.setattr(numba.config, "CACHE_DIR", "")
    monkeypatch.setattr(tempfile, "tempdir", str(tmp_path))
    monkeypatch.setattr(numba_cache, "__file__", str(tmp_path / "file" / "numba_cache.py"))
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "file" / "cache"))


def test_without_any_place_there_is_a_private_one(tmp_path: Path) -> None:
    (tmp_path / "file").touch()  # a directory can be made in no file, by nobody
    numba_cache.ensure_numba_cache()
    folder = Path(os.environ["NUMBA_CACHE_DIR"])
    assert str(folder) == numba.config.CACHE_DIR
    assert folder.parent == tmp_path
    assert folder.stat().st_mode & 0o077 == 0


@pytest.mark.parametrize("place", ["file/__pycache__", "file/cache/numba"])
def test_numbas_own_places_are_left_to_it(place: str, tmp_path: Path) -> None:
    for other in ("file/__pycache__", "file/cache/numba"):
        (tmp_path / other).parent.mkdir(parents=True, exist_ok=True)
        (tmp_path / other).mkdir() if other == place else (tmp_path / other).touch()
    numba_cache.ensure_numba_cache()
    assert "NUMBA_CACHE_DIR" not in os.environ


def test_a_place_that_is_given_is_kept(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (tmp_path / "file").touch()
    monkeypatch.setenv("NUMBA_CACHE_DIR", "mine")
    numba_cache.ensure_numba_cache()
    assert os.environ["NUMBA_CACHE_DIR"] == "mine"
