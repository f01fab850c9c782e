"""Beside roll and pitch that err the strength alone is believed, and the answer says so."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from diagnosis.evidence.along_field import is_attitude_error
from diagnosis.result import Diagnosis
from diagnosis.verdict import Verdict
from diagnosis.workflow import diagnose
from scenarios.toml import to_toml
from sim.effects.currents import MotorCurrent
from sim.scenario import ModelSpec, load_model
from tests.diagnosis.own_compass import IRON, with_own_compass
from tests.diagnosis.synthetic import COSTLY, FIELD_ENU_NT


def _found(gain_nT_A: float, wander_deg: float) -> Diagnosis:
    given = with_own_compass(0.05, IRON, gain_nT_A=gain_nT_A, wander_deg=wander_deg)
    return diagnose(given, ModelSpec(), field_enu_nT=FIELD_ENU_NT, fitted_base=True, without=COSTLY)


@pytest.mark.parametrize(("gain_nT_A", "verdict"), [(0.0, Verdict.NONE), (60.0, Verdict.NAMED)])
def test_where_roll_and_pitch_wander_the_strength_alone_is_believed(gain_nT_A: float, verdict: Verdict) -> None:
    found = _found(gain_nT_A, wander_deg=0.3)
    assert found.verdict is verdict
    assert {one.name for one in found.named} == ({MotorCurrent.name} if gain_nT_A else set())
    assert found.problem.compared == "strength"
    assert "only the field's strength was compared" in found.sentence
    (words,) = found.as_dict()["reference"]
    off_nT = float(words.split("off by ")[1].split(" nT")[0])
    assert off_nT == pytest.approx(np.radians(0.3) * np.linalg.norm(FIELD_ENU_NT), rel=0.3)


@pytest.mark.slow
def test_the_written_model_is_valid_and_leaves_no_gap_on_another_log(tmp_path: Path) -> None:
    first = _found(60.0, wander_deg=0.0)
    path = tmp_path / "model.toml"
    path.write_text(to_toml(first.model))
    model, other = load_model(path), with_own_compass(0.05, IRON, gain_nT_A=60.0, seed=4)
    assert first.problem.compared == "strength+dip"
    assert np.diag(model.chain()[0].matrix) == pytest.approx(np.diag(IRON) - 1, abs=2e-3)  # type: ignore[attr-defined]
    assert model.effects.written["white_noise"]["std_nT"] == pytest.approx([50.0] * 3, rel=0.05)
    with_it = diagnose(other, model)
    assert with_it.verdict is Verdict.NONE
    assert with_it.gap.before_sigma == pytest.approx(1.0, abs=0.03)
    without = diagnose(other, ModelSpec(), field_enu_nT=FIELD_ENU_NT, fitted_base=True)
    assert without.gap.before_nT > 1.1 * with_it.gap.before_nT


def test_a_current_across_the_field_is_named_by_the_dip() -> None:
    """Of half the noise: the strength in a steep field shows little of what lies level."""
    found = _found(12.0, wander_deg=0.0)
    assert found.problem.compared == "strength+dip"
    assert [one.name for one in found.named] == [MotorCurrent.name]
    assert found.after.clean
    assert not is_attitude_error(found.problem, found.before_nT / found.problem.sigma_nT)
