"""The page of verdicts: a section for each verdict, and the commands in it earn that verdict."""

from __future__ import annotations

import importlib.util
import sys
from collections.abc import Iterator
from types import ModuleType
from typing import get_args

import pytest

from tests.conftest import ROOT
from validation.diagnosis.result import Verdict


@pytest.fixture(scope="module")
def verdicts() -> Iterator[ModuleType]:
    """The module docs/verdicts.py."""
    spec = importlib.util.spec_from_file_location("docs_verdicts", ROOT / "docs" / "verdicts.py")
    assert spec is not None
    assert spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    sys.modules[spec.name] = module
    spec.loader.exec_module(module)
    yield module
    del sys.modules[spec.name]


def test_every_verdict_has_a_section_with_what_the_command_says_and_a_picture(verdicts: ModuleType) -> None:
    sections = verdicts.sections()
    assert tuple(sections) == get_args(Verdict) == tuple(verdicts.PICTURES)
    for verdict, text in sections.items():
        assert f"\nverdict: {verdict} (" in text, "run `make docs`"
        assert f"(pictures/verdict-{verdict}.png)" in text


@pytest.mark.slow
def test_every_section_earns_its_verdict(verdicts: ModuleType) -> None:
    found = {name: diagnosis.verdict for name, diagnosis in verdicts.diagnosed().items()}
    assert found == {name: name for name in get_args(Verdict)}
