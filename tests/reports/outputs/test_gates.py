"""What gates leave behind: read again by others' readers, and saying the same everywhere."""

from __future__ import annotations

import json
from collections.abc import Iterable
from pathlib import Path
from xml.etree import ElementTree

import numpy as np
import pytest

from reports.outputs.comparison import ANSWER
from reports.outputs.gates import FILES, github_lines, junit, propose_gates, run_gates
from scenarios.errors import InputError
from sim.scenario import load
from tests.reports.page import figures, without_scripts
from tests.validation.gates.conftest import Scripted, gate_text, groups_in, row
from validation.calibrating.selection import select_calibrators
from validation.comparison.design import Design
from validation.comparison.journal import JOURNAL, Journal
from validation.comparison.sealed_lines import SEAL_BYTES, sealed
from validation.comparison.trial import Trial, TrialRow
from validation.comparison.trial_table import TrialTable
from validation.gates.gate_file import load_gates
from validation.gates.gate_outcome import GateOutcome
from validation.gates.runner import decide_gates
from validation.scoring.definitions import score_definition
from validation.scoring.outcome import RANKED_BY

SPREAD = np.exp(0.5 * np.random.default_rng(4).standard_normal((3, 400)))


def told(group: int, run: int) -> Iterable[TrialRow]:
    """Two that are alike, paired within a few percent; one without estimate; one that is bad."""
    yield row("ellipsoid", SPREAD[0, run])
    yield row("twostep", SPREAD[0, run] * (1.04 + 0.05 * np.log(SPREAD[1, run])))
    yield row("ml_newton", SPREAD[0, run] * (1.14 + 0.4 * np.log(SPREAD[2, run])))
    yield row("sphere", 30.0 * SPREAD[1, run])
    yield row("kalman", None, "not_applicable", "needs an attitude\x07 | which is not there")
    yield row("uncorrected", 5000.0)


@pytest.fixture(scope="module")
def out(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return tmp_path_factory.mktemp("gates")


@pytest.fixture(scope="module")
def outcomes(out: Path) -> list[GateOutcome]:
    groups = groups_in(
        out.with_name("gates.toml"),
        gate_text("good", limit=2.0),
        gate_text("near", limit=1.05, max_trials=60),
        gate_text("bad", "sphere", limit=2.0),
        gate_text("none", "kalman", limit=2.0),
    )
    return run_gates(groups, Scripted(told), out, "gates.toml", 1e-4)


@pytest.mark.usefixtures("outcomes")
def test_junit_counts_and_names_every_gate(out: Path) -> None:
    suites = ElementTree.fromstring((out / "junit.xml").read_text())
    (suite,) = suites
    assert suite.attrib | {"name": "gates.toml", "tests": "4", "failures": "2", "skipped": "1"} == suite.attrib
    children = {case.get("name"): [child.tag for child in case] for case in suite}
    assert children == {
        "good": ["system-out"],
        "near": ["skipped", "system-out"],
        "bad": ["failure", "system-out"],
        "none": ["failure", "system-out"],
    }
    message = suite.findall("testcase/failure")[1].get("message") or ""
    assert "not_applicable: needs an attitude" in message


def test_with_strict_an_undecided_gate_is_a_failure(outcomes: list[GateOutcome]) -> None:
    assert ElementTree.fromstring(junit(outcomes, "gates.toml", strict=True)).get("failures") == "3"


@pytest.mark.usefixtures("outcomes")
def test_the_json_keeps_the_whole_way(out: Path) -> None:
    found = json.loads((out / "gates.json").read_text())
    assert found["verdict"] == "fail"
    good, near, bad, none = found["gates"]
    assert [one["verdict"] for one in found["gates"]] == ["pass", "inconclusive", "fail", "fail"]
    assert len(good["trajectory"]["log10_evidence_within"]) == good["trials"] == len(good["trajectory"]["value"])
    assert good["trajectory"]["log10_evidence_within"][-1] >= good["trajectory"]["log10_to_pass"]
    assert good["trajectory"]["log10_to_pass"] == pytest.approx(2.0)
    assert max(good["trajectory"]["log10_evidence_within"][:-1]) < 2.0
    assert good["measured"] < good["smallest_seen"]
    assert good["smallest_seen"] == pytest.approx(good["measured"] * good["smallest_seen_factor"])
    assert near["more_trials"] > 0
    assert bad["more_trials"] is None
    assert (none["measured"], none["smallest_seen"]) == (None, None)
    assert none["smallest_seen_exceedance"] > 0.5
    assert none["without_estimate"] == none["trials"]


@pytest.mark.usefixtures("outcomes")
def test_the_page_and_the_markdown_say_what_to_do(out: Path) -> None:
    text = (out / "summary.md").read_text()
    table = [line for line in text.splitlines() if line.startswith("| ")]
    assert len(table) == 6
    assert len({line.replace("\\|", "").count("|") for line in table}) == 1
    assert "2 of 4 gates failed, 1 inconclusive" in text
    assert "more trials would decide" in text
    page = (out / "report.html").read_text()
    assert figures(page) == 4
    assert "http" not in without_scripts(page)
    assert set(FILES) == {path.name for path in out.iterdir()}


def test_annotations_are_single_lines_that_name_the_file(outcomes: list[GateOutcome]) -> None:
    lines = github_lines(outcomes, Path("ci/gates, mine.toml"))
    assert [line.split(" ")[0] for line in lines] == ["::warning", "::error", "::error"]
    assert all("file=ci/gates%2C mine.toml,title=gate " in line for line in lines)
    assert all("\n" not in line and "\x07" not in line for line in lines)


@pytest.fixture
def comparison(tmp_path: Path) -> Path:
    """A comparison of 300 trials as it stands on disk."""
    place = tmp_path / "comparison"
    place.mkdir()
    (place / ANSWER).write_text(json.dumps({"ranked_by": RANKED_BY}))
    names = ("ellipsoid", "twostep", "ml_newton", "sphere", "kalman")
    design = Design.of(load("tumble", ["sampling.rate_hz=5"]), select_calibrators(names), seed=3)
    Journal.open(place, design.identity())
    column = score_definition(RANKED_BY).column

    def scored(one: TrialRow) -> TrialRow:
        scores = {column: one.scores["offset_error_nT"]} if one.scores else {}
        return TrialRow(one.calibrator, one.status, one.reason, scores, 0.0, 0.0)

    TrialTable.of(design, (Trial(0, run, tuple(map(scored, told(0, run)))) for run in range(300))).write(place)
    return place


def test_a_file_is_begun_with_limits_that_pass_and_says_what_they_cost(comparison: Path, tmp_path: Path) -> None:
    file = tmp_path / "begun" / "gates.toml"
    file.parent.mkdir()
    propose_gates(comparison, file)
    text, found = file.read_text(), load_gates(file)
    assert [gate.calibrator for gate in found.gate] == ["ellipsoid", "twostep", "ml_newton", "sphere"]
    assert found.seed == 3
    assert load(file.parent / found.gate[0].scenario).sampling.rate_hz == 5.0
    limits = {gate.calibrator: gate.factor for gate in found.gate}
    assert limits["twostep"] < limits["ml_newton"]  # as near to the reference, but costlier to tell
    assert "# Costly: a limit of" in text


def test_gates_begun_from_a_comparison_pass_on_it(comparison: Path, tmp_path: Path) -> None:
    propose_gates(comparison, tmp_path / "begun.toml")
    text = (tmp_path / "begun.toml").read_text().replace(RANKED_BY, "offset_error")
    outcomes = decide_gates(groups_in(tmp_path / "begun.toml", text), Scripted(told))
    assert {one.verdict for one in outcomes} == {"pass"}


def test_the_score_that_decided_the_comparison_is_held(comparison: Path, tmp_path: Path) -> None:
    (comparison / ANSWER).write_text('{"ranked_by": "heading_rms"}')
    with pytest.raises(InputError, match=r"no gate .*: ellipsoid gives no heading_rms"):  # the table has no such column
        propose_gates(comparison, tmp_path / "begun.toml")


def test_a_comparison_of_another_version_is_refused(comparison: Path, tmp_path: Path) -> None:
    journal = comparison / JOURNAL
    first, *rest = journal.read_bytes().splitlines(keepends=True)
    old = b"{" + first[SEAL_BYTES:].rstrip().replace(b'"format":2', b'"format":1')
    journal.write_bytes(b"".join([sealed(old.decode()), *rest]))
    with pytest.raises(InputError, match="another version"):
        propose_gates(comparison, tmp_path / "begun.toml")


def test_a_file_that_is_there_is_left_alone(comparison: Path, tmp_path: Path) -> None:
    (tmp_path / "gates.toml").write_text("mine")
    with pytest.raises(InputError, match="is there already"):
        propose_gates(comparison, tmp_path / "gates.toml")
    with pytest.raises(InputError):
        propose_gates(tmp_path, tmp_path / "other.toml")
