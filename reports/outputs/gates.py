"""Files of accuracy gates for people and continuous integration: JUnit XML, JSON, Markdown, page and annotations."""

from __future__ import annotations

import json
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from xml.etree import ElementTree

from recordings.files import locked_directory, remove_leftovers, write_text
from reports.outputs.comparison import ANSWER
from reports.pages.gates import gates_markdown, gates_page
from reports.text.gates import advice, detectable_defect, sentence
from scenarios.errors import InputError
from scenarios.files import parsed_json, read_text
from scenarios.toml import to_toml
from validation.comparison.engine import Engine
from validation.gates.gate_file import load_gates
from validation.gates.gate_groups import GateGroup
from validation.gates.gate_journal import open_gate_journal
from validation.gates.gate_outcome import GateOutcome
from validation.gates.proposal import gate_proposals
from validation.gates.proposal_file import FinishedComparison, gates_toml
from validation.gates.runner import Progress, decide_gates, record_scores
from validation.gates.score_baseline import check_place, write_baseline
from validation.gates.summary import full_summary
from validation.scoring.definitions import score_definition
from validation.scoring.outcome import RANKED_BY

FILES = ("junit.xml", "gates.json", "summary.md", "report.html")


def run_gates(
    groups: Sequence[GateGroup],
    engine: Engine,
    out: Path,
    title: str,
    false_fail_rate: float,
    progress: Progress = lambda done, total: None,
    *,
    strict: bool = False,
    warn: Callable[[str], object] = lambda text: None,
) -> list[GateOutcome]:
    """Run trials until every gate is decided and write FILES into `out`.

    strict : inconclusive gates are failures in junit.xml instead of skipped. Trials are kept until FILES are written: a
    killed run resumes, a finished run starts afresh.
    Raises InputError where `out` holds a comparison, and where the system refuses to write.
    """
    with locked_directory(out):
        remove_leftovers(out)
        journal = open_gate_journal(groups, out, warn)
        with journal.left_where_begun():
            outcomes = decide_gates(groups, engine, progress, journal)
        texts = (
            junit(outcomes, title, strict=strict),
            json.dumps(full_summary(outcomes), indent=1, allow_nan=False) + "\n",
            gates_markdown(outcomes, title),
            gates_page(outcomes, title, false_fail_rate),
        )
        for name, text in zip(FILES, texts, strict=True):
            write_text(out / name, text)
        journal.remove()
    return outcomes


def record_baseline(
    groups: Sequence[GateGroup], engine: Engine, path: Path, progress: Progress = lambda done, total: None
) -> int:
    """Write the scores of every gate's calibrator in all trials, return their number.

    Raises InputError where `path` cannot be written: for a missing folder before any trial.
    """
    check_place(path)
    parts = record_scores(groups, engine, progress)
    write_baseline(path, parts)
    return sum(part.num_rows for part in parts)


@dataclass(frozen=True)
class ProposalFiles:
    """The files of proposed gates, names of the gates, and why calibrators are left out, by name."""

    files: tuple[Path, ...]
    gates: tuple[str, ...]
    left_out: Mapping[str, str]


def propose_gates(comparison: Path, file: Path) -> ProposalFiles:
    """Write a gate file proposed from a comparison's directory.

    The gates limit the score that ranked the comparison. A scenario outside the catalogue is written beside the file.
    Raises InputError where a file exists, for a directory without comparison, where no gate would guard anything, and
    where the system refuses to write.
    """
    compared, score = FinishedComparison.read(comparison), score_definition(_ranked_by(comparison / ANSWER))
    found = gate_proposals(compared.table, score)
    texts = {file: gates_toml(compared, found, score)}
    if not compared.of_the_catalogue:
        texts[file.parent / f"{compared.scenario.name}.toml"] = to_toml(compared.scenario)
    for path in texts:
        _check_absent(path, texts[path])
    return ProposalFiles(tuple(texts), _written(file, texts), found.left_out)


def _written(file: Path, texts: Mapping[Path, str]) -> tuple[str, ...]:
    """Write the files and return the names of the gates; nothing new is left where the gate file is refused."""
    new = [path for path in texts if not path.exists()]
    for path, text in texts.items():
        write_text(path, text)
    try:
        return tuple(gate.name for gate in load_gates(file).gate)
    except InputError:
        for path in new:
            path.unlink()
        raise


def _check_absent(path: Path, text: str) -> None:
    """Refuse to replace a file of another content; raises InputError."""
    if path.exists() and (path.is_dir() or path.read_bytes() != text.encode()):
        raise InputError("is there already", where=str(path), do="name another file with -o, or remove it")


def _ranked_by(answer: Path) -> str:
    """Return the score that ranked a comparison."""
    found = parsed_json(read_text(answer, "repeat the comparison, which resumes"), str(answer), "compare anew")
    return str(found.get("ranked_by", RANKED_BY)) if isinstance(found, dict) else RANKED_BY


def junit(outcomes: list[GateOutcome], title: str, *, strict: bool) -> str:
    """Return JUnit XML, a test case per gate; an inconclusive gate is skipped, or failed with `strict`."""
    suites = ElementTree.Element("testsuites")
    suite = ElementTree.SubElement(suites, "testsuite", name=_printable(title), errors="0")
    number = {"tests": len(outcomes), "failures": 0, "skipped": 0}
    for outcome in outcomes:
        gate = outcome.plan.gate
        place = _printable(f"gates.{gate.scenario}")
        case = ElementTree.SubElement(suite, "testcase", classname=place, name=gate.name, time="0")
        if outcome.verdict != "pass":
            failed = strict or outcome.verdict == "fail"
            number["failures" if failed else "skipped"] += 1
            result = ElementTree.SubElement(case, "failure" if failed else "skipped", message=_message(outcome))
            if failed:
                result.set("type", outcome.verdict)
                result.text = _printable(advice(outcome))
        ElementTree.SubElement(case, "system-out").text = _printable(
            f"{sentence(outcome)}; {detectable_defect(outcome)}"
        )
    for element in (suites, suite):
        element.attrib.update({key: str(value) for key, value in number.items()})
    ElementTree.indent(suites)
    return ElementTree.tostring(suites, encoding="unicode", xml_declaration=False) + "\n"


def github_lines(outcomes: list[GateOutcome], file: Path) -> list[str]:
    """Return GitHub annotations at the gate file: an error per failed gate, a warning per inconclusive gate."""
    kinds = {"fail": "error", "inconclusive": "warning"}
    return [
        f"::{kinds[one.verdict]} file={_property(str(file))},title={_property(f'gate {one.plan.gate.name}')}::"
        f"{_escaped(_message(one))}"
        for one in outcomes
        if one.verdict in kinds
    ]


def _message(outcome: GateOutcome) -> str:
    return _printable(f"{sentence(outcome)}. To do: {advice(outcome)}")


def _printable(text: str) -> str:
    """Replace control characters, which XML cannot hold, by spaces."""
    return "".join(character if character.isprintable() else " " for character in text)


def _escaped(text: str) -> str:
    return text.replace("%", "%25").replace("\r", "%0D").replace("\n", "%0A")


def _property(text: str) -> str:
    return _escaped(text).replace(":", "%3A").replace(",", "%2C")
