"""`magbench.gate`."""

from __future__ import annotations

from collections.abc import Callable
from os import PathLike
from pathlib import Path
from typing import TYPE_CHECKING

from magbench.api.inputs import Progress, check_count, engine, in_keywords, path_of, place_for

if TYPE_CHECKING:
    from magbench.api.gate_result import GateResult


@in_keywords()
def gate(
    gates: str | PathLike[str],
    out: str | PathLike[str] | None = None,
    *,
    seed: int | None = None,
    time_limit_s: float | None = None,
    strict: bool = False,
    jobs: int | None = None,
    scheduler: str | None = None,
    progress: Progress = lambda done, total: None,
    warn: Callable[[str], object] = lambda text: None,
) -> GateResult:
    """Hold calibrators to the limits of a file; trials are computed one by one, until every gate is decided.

    gates : a gates.toml. out : directory for report.html, gates.json, junit.xml and summary.md. strict : inconclusive
    gates count as failed. seed, time_limit_s : in place of the file's. jobs, scheduler : as in `compare`.
    warn : gets a line about damaged trials of `out`, which are computed again.

    Raises InputError for a file that cannot be used. A gate of one calibrator in a test: `magbench.testing`.

    >>> import magbench
    >>> from pathlib import Path
    >>> text = '''
    ... [[gate]]
    ... name = "ellipsoid on a short tumble"
    ... scenario = "tumble"
    ... set = ["phases.0.duration_s=60"]
    ... calibrator = "ellipsoid"
    ... score = "offset_error_nT"
    ... limit = 10000
    ... '''
    >>> size = Path("gates.toml").write_text(text)
    >>> magbench.gate("gates.toml")
    1 gate passed
    """
    from magbench.api.gate_result import GateResult
    from reports.outputs.gates import run_gates
    from validation.gates.gate_file import load_gates
    from validation.gates.gate_groups import group_gates

    check_count("--jobs", jobs)
    path = path_of(gates)
    file, who = load_gates(path), engine(scheduler, jobs)
    groups = group_gates(file, path, seed, time_limit_s)
    with place_for(out) as place:
        rate = file.false_fail_rate
        outcomes = run_gates(groups, who, place, path.name, rate, progress, strict=strict, warn=warn)
    return GateResult(tuple(outcomes), strict)


@in_keywords()
def write_baseline(
    gates: str | PathLike[str],
    file: str | PathLike[str],
    *,
    seed: int | None = None,
    time_limit_s: float | None = None,
    jobs: int | None = None,
    scheduler: str | None = None,
    progress: Progress = lambda done, total: None,
) -> int:
    """Compute all trials of a file of gates and write their scores as a baseline; returns the number of scores.

    Raises InputError for a file that cannot be used.

    >>> import magbench
    >>> from pathlib import Path
    >>> text = '''
    ... [[gate]]
    ... name = "no worse than today"
    ... scenario = "tumble"
    ... set = ["phases.0.duration_s=60"]
    ... calibrator = "ellipsoid"
    ... score = "offset_error_nT"
    ... baseline = "today.parquet"
    ... max_trials = 25
    ... '''
    >>> size = Path("gates.toml").write_text(text)
    >>> magbench.write_baseline("gates.toml", "today.parquet")
    25
    """
    from reports.outputs.gates import record_baseline
    from validation.gates.gate_file import load_gates
    from validation.gates.gate_groups import group_gates

    path = path_of(gates)
    groups = group_gates(load_gates(path), path, seed, time_limit_s, baselines=False)
    return record_baseline(groups, engine(scheduler, jobs), Path(file), progress)


@in_keywords()
def propose_gates(
    comparison: str | PathLike[str],
    file: str | PathLike[str],
    *,
    warn: Callable[[str], object] = lambda text: None,
) -> list[str]:
    """Write a file of gates with limits from the directory of a comparison; returns the names of the gates.

    warn : gets a line about each calibrator that no gate can guard, which is left out, and why.

    Raises InputError for a directory without a comparison, for a file that exists, and where no gate would guard
    anything.

    >>> import magbench
    >>> short = ["phases.0.duration_s=60"]
    >>> found = magbench.compare("tumble", "compared", trials=20, with_=["ellipsoid"], overrides=short)
    >>> magbench.propose_gates("compared", "begun.toml")
    ['ellipsoid holdout_level_component_rms']
    """
    from reports.outputs.gates import propose_gates as write_proposal

    found = write_proposal(path_of(comparison), Path(file))
    for name, why in found.left_out.items():
        warn(f"no gate for {name}: {why}")
    return list(found.gates)
