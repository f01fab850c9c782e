"""The examples in the docstrings of the product run and give what they say."""

from __future__ import annotations

import doctest
import inspect
import re
from importlib import import_module
from pathlib import Path
from unittest import mock

import pytest

import magbench
from tests.imports import FILES, name_of
from validation.calibrating.registry import REGISTERED

EXAMPLE = re.compile(r"^\s*>>> ", re.MULTILINE)
WITH_EXAMPLES = [path for path in FILES if EXAMPLE.search(path.read_text(encoding="utf-8"))]


@pytest.mark.parametrize("path", WITH_EXAMPLES, ids=name_of)
def test_examples_give_what_they_say(
    path: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, undrawn: None
) -> None:
    monkeypatch.chdir(tmp_path)
    name = name_of(path).removesuffix(".py").removesuffix("/__init__").replace("/", ".")
    with mock.patch.dict(REGISTERED):
        done = doctest.testmod(import_module(name), optionflags=doctest.NORMALIZE_WHITESPACE | doctest.ELLIPSIS)
    assert done.attempted
    assert not done.failed


FUNCTIONS = [name for name in magbench.__all__ if inspect.isfunction(getattr(magbench, name))]


@pytest.mark.parametrize("name", FUNCTIONS)
def test_every_public_function_has_an_example(name: str) -> None:
    function = inspect.unwrap(getattr(magbench, name))
    assert EXAMPLE.search(inspect.getdoc(function) or "")
    assert Path(inspect.getfile(function)) in WITH_EXAMPLES
