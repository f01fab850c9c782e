"""A level turn, with three columns and with two, from the file to parameters."""

from __future__ import annotations

from pathlib import Path

import pytest

import magbench

CASES = Path(__file__).parents[1] / "recordings" / "cases"


@pytest.mark.parametrize("name", ["level_circle.csv", "level_2d.csv"])
def test_planar_answers_without_being_named(name):
    found = magbench.calibrate(CASES / name, 48_000.0, with_=[])
    assert found["planar"].status.kind == "ok"
    assert {key for key, one in found.items() if one.status.kind == "ok"} == {"planar"}


def test_parameters_of_z_are_not_exported(tmp_path):
    magbench.calibrate(CASES / "level_circle.csv", 48_000.0, with_="planar", out=tmp_path, exports=["px4", "ardupilot"])
    for file in ("px4.params", "ardupilot.param"):
        lines = (tmp_path / file).read_text(encoding="utf-8").splitlines()
        assert any("XOFF" in line or "OFS_X" in line for line in lines)
        assert not any(word in line for line in lines for word in ("ZOFF", "ZSCALE", "OFS_Z", "DIA_Z", "ODI_Z"))
