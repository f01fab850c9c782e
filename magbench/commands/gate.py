"""`magbench gate`: fail a build where a calibrator does not keep its limits."""

from __future__ import annotations

import os
import sys
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from magbench.arguments import present
from magbench.options import CORES, Jobs, Json, Scheduler, Seed
from validation.calibrating.processes import LEAST_TIME_LIMIT_S, MOST_TIME_LIMIT_S, TIME_LIMIT_S

if TYPE_CHECKING:
    from magbench.api.gate_result import GateResult

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
Strict = Annotated[bool, typer.Option("--strict", help="A gate that is left inconclusive fails too.")]
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


def command(
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
    """Hold calibrators to the limits of a file. Trials are looked at one by one, until every gate is decided.

    Status 1 where a gate failed; one that is left inconclusive is a warning, or with --strict status 1 too.

    Example: magbench gate gates.toml -o out/gates --jobs 2
    """
    from magbench.api.gate import gate
    from magbench.api.gate import write_baseline as record_baseline
    from magbench.console import emit, progress, say, warn
    from scenarios.errors import InputError

    if init is not None:
        return _propose(init, out or Path("gates.toml"), json)
    if gates is None:
        raise InputError("no file of gates is named", where="GATES.toml", do="name one, or write one with --init")
    given: dict[str, Any] = {"seed": seed, "time_limit_s": time_limit_s, "jobs": jobs, "scheduler": scheduler}
    if write_baseline is not None:
        with progress("scores for a baseline") as report:
            scores = record_baseline(gates, write_baseline, **given, progress=report)
        say(f"{write_baseline}: {scores} scores")
        return emit({"scores": scores, "out": str(write_baseline)}) if json else None
    place = out or Path("out") / gates.stem
    with progress(f"gates of {gates.name}") as report:
        found = gate(gates, place, **given, strict=strict, progress=report, warn=warn)
    _show(found, place, gates, json)
    if found.failed:
        raise typer.Exit(1)
    return None


def _propose(comparison: Path, file: Path, json: bool) -> None:
    """Write a file of gates from a comparison."""
    from magbench.console import emit, progress, say, warn
    from validation.text import counted, listed

    with progress(f"proposing gates from {comparison.name}"):
        from reports.outputs.gates import propose_gates  # here: loads what takes seconds

        found = propose_gates(comparison, file)
    for name, why in found.left_out.items():
        warn(f"no gate for {name}: {why}")
    written = listed([str(path) for path in found.files])
    say(f"{written}: {counted(len(found.gates), 'gate')}; read what each costs, then: magbench gate {file}")
    if json:
        plain = {"gates": found.gates, "left_out": found.left_out, "files": [str(path) for path in found.files]}
        emit(plain | {"out": str(file)})


def _show(found: GateResult, place: Path, gates: Path, json: bool) -> None:
    """The verdicts on standard output, reasons and remedies on standard error."""
    from magbench.console import emit, say, show_table, warn
    from reports.outputs.gates import FILES, github_lines
    from reports.text.gates import HEADS, advice, gate_rows, sentence
    from validation.gates.summary import summary

    if json:
        emit(summary(found.outcomes) | {"out": str(place)})
    else:
        show_table(repr(found), HEADS, gate_rows(found.outcomes), numbers=False)
    for outcome in found.outcomes:
        if outcome.verdict != "pass":
            warn(f"gate {outcome.plan.gate.name}: {outcome.verdict}: {sentence(outcome)} ({advice(outcome)})")
    if os.environ.get("GITHUB_ACTIONS"):
        for line in github_lines(list(found.outcomes), gates):
            print(line, file=sys.stderr)
    say(f"{place}: {', '.join(FILES)}")
