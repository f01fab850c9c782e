"""What `calibrate --export` writes, and for which calibrator."""

from __future__ import annotations

from pathlib import Path

import pytest

from magbench.cli import main
from tests.conftest import ROOT

LOG = ROOT / "tests" / "recordings" / "cases" / "base.csv"
STRENGTH = ("--field-strength-nT", "48000")


def files(place: Path) -> list[str]:
    return sorted(path.relative_to(place).as_posix() for path in place.rglob("*") if path.is_file())


def test_without_a_name_the_recommended_calibration_is_exported(tmp_path: Path) -> None:
    """The sphere of this log is unobservable; the ellipsoid's offset is (12000, -8000, 25000) nT within some 30 nT."""
    assert main(["calibrate", str(LOG), *STRENGTH, "-o", str(tmp_path), "--export", "px4,c"]) == 0
    assert files(tmp_path) == ["calibration.json", "mag_calibration.h", "px4.params", "report.html"]
    words = (line.split() for line in (tmp_path / "px4.params").read_text().splitlines())
    values = {word[2]: float(word[3]) for word in words if word[2].startswith("CAL_")}
    assert values["CAL_MAG0_XOFF"] == pytest.approx(0.12, abs=5e-4)
    assert values["CAL_MAG0_ZOFF"] == pytest.approx(-0.25, abs=5e-4)


def test_every_named_calibrator_is_exported_or_refused(tmp_path: Path) -> None:
    both = ("--with", "sphere,ellipsoid", "--export", "px4")
    assert main(["calibrate", str(LOG), *STRENGTH, "-o", str(tmp_path), *both]) == 2
    assert files(tmp_path) == ["calibration.json", "ellipsoid/px4.params", "report.html"]


def test_nothing_is_exported_where_none_is_recommended(tmp_path: Path) -> None:
    partial = LOG.with_name("partial_nT.csv")
    assert main(["calibrate", str(partial), *STRENGTH, "-o", str(tmp_path), "--export", "px4"]) == 2
    assert files(tmp_path) == ["calibration.json", "report.html"]
