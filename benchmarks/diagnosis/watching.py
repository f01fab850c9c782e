"""Pytest plugin: which rules of the diagnosis had a say in each test, or the tests with one rule off.

MAGBENCH_WATCH=out/say.jsonl python -m pytest -p benchmarks.diagnosis.watching tests/diagnosis
MAGBENCH_RULE_OFF=selection._grows_with_time python -m pytest -p benchmarks.diagnosis.watching TESTS
"""

from __future__ import annotations

import json
import os
from collections.abc import Generator
from contextlib import ExitStack
from pathlib import Path

import pytest

from benchmarks.diagnosis.rules import watched

_open = ExitStack()
_fired = _open.enter_context(watched(os.environ.get("MAGBENCH_RULE_OFF", "")))


@pytest.hookimpl(wrapper=True)
def pytest_runtest_protocol(item: pytest.Item) -> Generator[None, object, object]:
    """Write the rules that had a say in a test as a line of JSON."""
    _fired.clear()
    try:
        return (yield)
    finally:
        if path := os.environ.get("MAGBENCH_WATCH"):
            with Path(path).open("a") as file:
                file.write(json.dumps({"test": item.nodeid, "rules": [name for name, n in _fired.items() if n]}) + "\n")


def pytest_unconfigure() -> None:
    """Put the rules back."""
    _open.close()
