"""The words that ask for a calibrator again give the same calibrator, from another directory too."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from validation.calibrating.invocation import Invocation
from validation.calibrating.selection import select_calibrator, select_calibrators


@pytest.mark.parametrize("text", ["ellipsoid", "mine=json:loads", "json:loads"])
def test_a_name_and_an_object_are_asked_for_again(text: str) -> None:
    (one,) = select_calibrators([text], time_limit_s=7.0)
    asked = Invocation.of(one)
    assert asked is not None
    assert asked.calibrator == text
    assert Invocation.read(json.loads(json.dumps(asked.plain()))) == asked
    assert select_calibrators([asked.calibrator], time_limit_s=7.0) == (one,)


def test_a_program_is_asked_for_from_here(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    (tmp_path / "my tools").mkdir()
    (tmp_path / "my tools" / "fit.sh").write_text("true")
    text = "mine=sh 'my tools/fit.sh' --out={result} {recording}"
    (one,) = select_calibrators((), [text], 7.0)
    asked = Invocation.of(one)
    assert asked is not None
    assert (asked.calibrator, asked.time_limit_s) == ("mine", 7.0)
    assert asked.exec == "sh './my tools/fit.sh' --out={result} {recording}"
    assert select_calibrators((), [f"mine={asked.exec}"], 7.0) == (one,)
    (tmp_path / "elsewhere").mkdir()
    monkeypatch.chdir(tmp_path / "elsewhere")
    assert select_calibrators((), [f"mine={asked.exec}"], 7.0) == (one,)


def test_an_object_in_memory_has_no_words() -> None:
    assert Invocation.of(select_calibrator(lambda recording, reference: None)) is None
