"""The pytest plugin: the fixture `assert_accuracy`, and a summary of the gates at the end of a run.

A module outside magbench, since pytest imports it in every project where magbench is installed: nothing of magbench is
imported before a test requests the fixture.
"""

from __future__ import annotations

import json
from collections import Counter
from collections.abc import Iterator
from typing import TYPE_CHECKING, Any

import pytest

if TYPE_CHECKING:
    from magbench.testing import AssertAccuracy

PROPERTY = "magbench_gate"
"""What a test's report calls a gate; reports reach the end of the run from xdist's workers too, and JUnit XML."""
VERDICTS = {"pass": "passed", "fail": "failed", "inconclusive": "inconclusive"}


@pytest.fixture
def assert_accuracy(request: pytest.FixtureRequest) -> Iterator[AssertAccuracy]:
    """`magbench.testing.assert_accuracy`, with its gates listed at the end of the run."""
    from magbench import testing

    def listener(gate: dict[str, Any]) -> None:
        request.node.user_properties.append((PROPERTY, json.dumps(gate)))

    testing.LISTENERS.append(listener)
    yield testing.assert_accuracy
    testing.LISTENERS.remove(listener)


def pytest_terminal_summary(terminalreporter: pytest.TerminalReporter) -> None:
    """A line about all gates; with -v a line for each gate."""
    gates = list(_gates(terminalreporter.stats))
    if not gates:
        return
    if terminalreporter.verbosity > 0:
        terminalreporter.section("accuracy gates")
        for test, gate in gates:
            terminalreporter.write_line(_line(test, gate))
    number = Counter(gate["verdict"] for _, gate in gates)
    verdicts = ", ".join(f"{number[verdict]} {word}" for verdict, word in VERDICTS.items() if number[verdict])
    rate = sum(gate["false_fail_rate"] for _, gate in gates)
    terminalreporter.write_line(
        f"accuracy gates: {verdicts}; where every limit is kept, one fails in at most {rate:.2g} of such runs"
    )


def _gates(stats: dict[str, list[Any]]) -> Iterator[tuple[str, dict[str, Any]]]:
    """Test and gate, of every test's last report."""
    for report in (report for reports in stats.values() for report in reports):
        if getattr(report, "when", "") == "teardown":
            properties = report.user_properties
            yield from ((report.nodeid, json.loads(value)) for name, value in properties if name == PROPERTY)


def _line(test: str, gate: dict[str, Any]) -> str:
    def amount(key: str) -> str:
        value = gate[key]
        return "none" if value is None else f"{value:.3g} {gate['unit']}".rstrip()

    measured = f"{gate['score']} {amount('measured')}, limit {amount('limit')}, {gate['trials']} trials"
    return f"{gate['verdict']}: {gate['name']}: {measured}, catches {amount('smallest_seen')} ({test})"
