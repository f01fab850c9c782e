"""Files against a model's file, or against none: then hard and soft iron are fitted, and are no finding."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest

from diagnosis.question import Question, answer, file_sources
from diagnosis.result import Diagnosis
from recordings import write_recording
from scenarios.errors import InputError
from sim.effects.iron import HardIron
from tests.diagnosis.synthetic import FIELD_ENU_NT, NOISE_NT, recording

OFFSET_NT = (500.0, -300.0, 800.0)
FIELD = {"field_enu_nT": FIELD_ENU_NT.tolist()}


def diagnosed(file: Path, model: str | None, confirm: Path | None = None, **stated: Any) -> Diagnosis:
    """The diagnosis of one file."""
    second = None if confirm is None else file_sources([confirm], None)[0]
    found = answer(Question.about(model, **stated), file_sources([file], None), second)
    assert isinstance(found, Diagnosis)
    return found


@pytest.fixture
def measured(tmp_path: Path) -> Path:
    """A flight with hard iron in its magnetometer."""
    path = tmp_path / "measured.parquet"
    write_recording(recording(1000, hidden={HardIron.name: {"offset_nT": OFFSET_NT}}), path)
    return path


def test_without_a_model_iron_is_fitted_and_goes_into_the_new_model(measured: Path) -> None:
    found = diagnosed(measured, None, **FIELD)
    assert (found.verdict, found.named) == ("none", ())
    (iron,) = (effect for effect in found.model.chain() if isinstance(effect, HardIron))
    assert iron.offset_nT == pytest.approx(OFFSET_NT, abs=10 * NOISE_NT / np.sqrt(1000))


def test_iron_that_a_model_lacks_is_a_finding(measured: Path) -> None:
    bare = measured.with_name("bare.toml")
    bare.write_text(f"field.enu_nT = {FIELD_ENU_NT.tolist()}\neffects.white_noise.std_nT = {[NOISE_NT] * 3}\n")
    (one,) = diagnosed(measured, str(bare)).named
    assert HardIron.name in (one.name, *one.alternatives)


def test_without_a_field_everything_that_would_tell_it_is_said(measured: Path) -> None:
    with pytest.raises(InputError, match=r"--field-enu-nT.*--model whose \[field\] has latitude_deg"):
        diagnosed(measured, None)


def test_a_recording_does_not_confirm_itself(measured: Path) -> None:
    with pytest.raises(InputError, match="--confirm: both recordings have the same field samples"):
        diagnosed(measured, None, measured, **FIELD)


def test_of_several_recordings_the_one_that_is_too_short_is_named(measured: Path) -> None:
    short = measured.with_name("short.parquet")
    write_recording(recording(200).taken(slice(60)), short)
    with pytest.raises(InputError, match="--confirm: 60 samples"):
        diagnosed(measured, None, short, **FIELD)
    with pytest.raises(InputError, match="short: 60 samples"):
        answer(Question.about(None, **FIELD), file_sources([measured, short], None))
