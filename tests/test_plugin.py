"""The pytest plugin in another project's run: the fixture, the end of the run, and what it imports."""

from __future__ import annotations

import json
import re
import subprocess
import sys
from xml.etree import ElementTree

import pytest

from magbench import testing
from tests.conftest import ROOT
from tests.magbench.test_testing import OWN_MODULE, SCENARIO
from validation.gates import single_gate as alone
from validation.gates import summary

pytest_plugins = "pytester"
LOADED = (alone, summary, testing)
"""A run within this process forgets what it imports first, and numpy cannot be imported twice."""
TESTS = """
from their_own import fit
from magbench.testing import assert_accuracy as plain

def test_kept(assert_accuracy):
    assert_accuracy(fit, "on-the-table.toml", score="offset_error", limit=8.0)

def test_broken(assert_accuracy):
    assert_accuracy(fit, "on-the-table.toml", score="offset_error", limit=6.0)

def test_left_open(assert_accuracy):
    keys = dict(max_trials=21, power=1 - 1e-8, inconclusive="skip")
    assert_accuracy(fit, "on-the-table.toml", score="offset_error", limit=8.0, **keys)

def test_the_fixture_is_the_function(assert_accuracy):
    assert assert_accuracy is plain
"""


@pytest.fixture
def project(pytester: pytest.Pytester) -> pytest.Pytester:
    """A project with a scenario and a calibrator that is wrong by 7 nT."""
    pytester.makefile(".toml", **{"on-the-table": SCENARIO})
    pytester.makepyfile(their_own=OWN_MODULE, test_own=TESTS)
    pytester.syspathinsert()
    return pytester


def test_the_end_of_a_run_tells_of_its_gates(project: pytest.Pytester) -> None:
    done = project.runpytest_inprocess("-p", "pytest_magbench", "-v", "--junit-xml=report.xml")
    done.assert_outcomes(passed=2, failed=1, skipped=1)
    done.stdout.fnmatch_lines(
        [
            "E *AssertionError: fit on on-the-table: fail: median offset_error is 7 nT, the limit 6 nT, *",
            "test_own.py:8: AssertionError",
            "pass: fit on on-the-table: offset_error_nT 7 nT, limit 8 nT, 9 trials, * (test_own.py::test_kept)",
            "accuracy gates: 1 passed, 1 failed, 1 inconclusive; *at most 0.0003 of such runs",
        ]
    )
    properties = ElementTree.parse(project.path / "report.xml").iter("property")
    verdicts = [json.loads(one.attrib["value"])["verdict"] for one in properties]
    assert sorted(verdicts) == ["fail", "inconclusive", "pass"]
    assert not testing.LISTENERS


def test_the_tests_on_the_page_pass(pytester: pytest.Pytester) -> None:
    page = (ROOT / "docs" / "gates.md").read_text(encoding="utf-8")
    (code,) = re.findall(r"^```python\n(# test_accuracy.py\n.*?)^```$", page, re.MULTILINE | re.DOTALL)
    pytester.makepyfile(test_accuracy=code)
    pytester.runpytest_inprocess("-p", "pytest_magbench").assert_outcomes(passed=2)


def test_a_run_without_gates_says_nothing_of_them(pytester: pytest.Pytester) -> None:
    pytester.makepyfile("def test_one():\n    pass\n")
    done = pytester.runpytest_inprocess("-p", "pytest_magbench")
    done.assert_outcomes(passed=1)
    done.stdout.no_fnmatch_line("*accuracy*")


@pytest.mark.slow
def test_workers_tell_too(project: pytest.Pytester, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("PYTHONPATH", str(ROOT))
    done = project.runpytest_subprocess("-p", "pytest_magbench", "-n", "1", "-k", "kept")
    done.assert_outcomes(passed=1)
    done.stdout.fnmatch_lines(["accuracy gates: 1 passed; *"])


def test_the_plugin_imports_nothing_of_magbench() -> None:
    code = "import sys, json, pytest; there = {*sys.modules}; import pytest_magbench; print(*{*sys.modules} - there)"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.split() == ["pytest_magbench"]
