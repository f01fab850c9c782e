"""`magbench gate`: fail a build where a calibrator does not keep its limits."""

from __future__ import annotations

import os
import sys
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from magbench.arguments import present
from magbench.options import CORES, Jobs, Json, Scheduler, Seed
from validation.calibrating.processes import LEAST_TIME_LIMIT_S, MOST_TIME_LIMIT_S, TIME_LIMIT_S

if TYPE_CHECKING:
    from validation.comparison.engine import Engine
    from validation.gates.gate_groups import GateGroup
    from validation.gates.gate_outcome import GateOutcome

Gates = Annotated[
    Path | None, typer.Argument(metavar="GATES.toml", help="A file of gates.", callback=present, show_default=False)
]
Out = Annotated[
    Path | None,
    typer.Option("--out", "-o", help="Directory for the results, with --init the file.  [default: out/GATES]"),
]
TimeLimit = Annotated[
    float | None,
    typer.Option(
        "--time-limit-s",
        min=LEAST_TIME_LIMIT_S,
        max=MOST_TIME_LIMIT_S,
        help=f"For one fit of a calibrator that is not magbench's.  [default: the file's, or {TIME_LIMIT_S:g}]",
    ),
]
Strict = Annotated[bool, typer.Option("--strict", help="A gate that is left undecided fails too.")]
Baseline = Annotated[
    Path | None,
    typer.Option(metavar="FILE", help="Judge nothing: run all trials and write the scores for gates with a baseline."),
]
Init = Annotated[
    Path | None,
    typer.Option(
        metavar="DIRECTORY", help="Write a file of gates to begin with, from a comparison's output.", callback=present
    ),
]


def gate(
    gates: Gates = None,
    out: Out = None,
    time_limit_s: TimeLimit = None,
    seed: Seed = None,
    jobs: Jobs = CORES,
    scheduler: Scheduler = None,
    strict: Strict = False,
    write_baseline: Baseline = None,
    init: Init = None,
    json: Json = False,
) -> None:
    """Hold calibrators to the limits of a file; trials are looked at one by one, until every gate is decided.

    Status 1 where a gate failed; one that is left undecided is a warning, or with --strict status 1 too.

    Example: magbench gate gates.toml -o out/gates --jobs 2
    """
    from magbench.arguments import engine
    from magbench.console import progress
    from reports.outputs.gates import run_gates
    from scenarios.errors import InputError
    from validation.gates.gate_file import load_gates
    from validation.gates.gate_groups import group_gates

    if init is not None:
        return _begin(init, out or Path("gates.toml"), json)
    if gates is None:
        raise InputError("no file of gates is named", where="GATES.toml", do="name one, or begin one with --init")
    file, who = load_gates(gates), engine(scheduler, jobs)
    groups = group_gates(file, gates, seed, time_limit_s, baselines=write_baseline is None)
    if write_baseline is not None:
        return _record(groups, who, write_baseline, json)
    place = out or Path("out") / gates.stem
    with progress(f"gates of {gates.name}") as report:
        outcomes = run_gates(groups, who, place, gates.name, file.false_fail_rate, report, strict=strict)
    _show(outcomes, place, gates, json)
    failing = {"fail", "inconclusive"} if strict else {"fail"}
    if failing & {one.verdict for one in outcomes}:
        raise typer.Exit(1)
    return None


def _show(outcomes: list[GateOutcome], place: Path, gates: Path, json: bool) -> None:
    """The verdicts on standard output, why and what to do on standard error."""
    from magbench.console import emit, say, show_table, warn
    from reports.outputs.gates import FILES, github_lines
    from reports.text.gates import HEADS, advice, gate_rows, headline, sentence
    from validation.gates.summary import summary

    if json:
        emit(summary(outcomes) | {"out": str(place)})
    else:
        show_table(headline(outcomes), HEADS, gate_rows(outcomes), numbers=False)
    for one in outcomes:
        if one.verdict != "pass":
            warn(f"gate {one.plan.gate.name}: {one.verdict}: {sentence(one)} ({advice(one)})")
    if os.environ.get("GITHUB_ACTIONS"):
        for line in github_lines(outcomes, gates):
            print(line, file=sys.stderr)
    say(f"{place}: {', '.join(FILES)}")


def _record(groups: Sequence[GateGroup], engine: Engine, file: Path, json: bool) -> None:
    """Write the baseline."""
    from magbench.console import emit, progress, say
    from reports.outputs.gates import record_baseline

    with progress("scores for a baseline") as report:
        scores = record_baseline(groups, engine, file, report)
    say(f"{file}: {scores} scores")
    if json:
        emit({"scores": scores, "out": str(file)})


def _begin(comparison: Path, file: Path, json: bool) -> None:
    """Write a file of gates to begin with."""
    from magbench.console import emit, say
    from reports.outputs.gates import propose_gates

    written = propose_gates(comparison, file)
    say(f"{file}: {len(written)} gates; read what each costs, then: magbench gate {file}")
    if json:
        emit({"gates": written, "out": str(file)})
