"""The report of a long comparison from its journal: seconds of CPU and memory.

Of 2.5 s the journal's checksums take 0.3, its numbers 0.7 (both 0.1 at the next look), the table 0.2, the bounds of the
runs 0.5 (not in this row, since a benchmark would have to compute them first), ranking and statistics 0.5, the figures
of the page 0.3.
"""

from __future__ import annotations

import json
import subprocess
import sys
import tempfile
import time
from dataclasses import asdict
from pathlib import Path

import numpy as np

from benchmarks.comparison import short_spiral
from benchmarks.measure import Row
from calib import CALIBRATORS
from reports.pages.comparison import Comparison, comparison_page
from validation.calibrating.selection import select_calibrators
from validation.comparison.design import Design
from validation.comparison.journal import Journal
from validation.comparison.ranking import rank_calibrators
from validation.comparison.sealed_lines import sealed
from validation.comparison.trial import Trial, TrialRow
from validation.comparison.trial_columns import COLUMNS
from validation.comparison.trial_table import TrialTable
from validation.scoring.definitions import score_definition
from validation.scoring.evaluation import UNCORRECTED
from validation.scoring.outcome import RANKED_BY

MOST_S, MOST_MIB = 3.0, 1000.0
MOST_AGAIN_S = 0.5
"""Seconds of CPU to read a journal that was read before."""
TRIALS, SMALL = 10_000, 20
"""Trials of the comparison; the second is for a test of the benchmark."""
CALIBRATORS_COMPARED, FITTING = 20, 12
"""Calibrators, and those of them that give an estimate."""


def rows(small: bool = False) -> list[Row]:
    """Return the seconds of a report, and the peak of a process that does nothing else."""
    trials = SMALL if small else TRIALS
    with tempfile.TemporaryDirectory() as folder:
        code = f"from benchmarks.report import told; told({trials}, {folder!r})"
        told_by = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True).stdout
    taken_s, again_s, peak_MiB, megabytes = map(float, told_by.split())
    note = f"{trials} trials, {CALIBRATORS_COMPARED} calibrators: journal of {megabytes:.0f} MB to table and page"
    return [
        Row("comparison: report, CPU s", taken_s, MOST_S, False, note),
        Row("comparison: journal at the next look, CPU s", again_s, MOST_AGAIN_S, False, "from the columns beside it"),
        Row("comparison: report, peak MiB", peak_MiB, MOST_MIB, False, "with the libraries"),
    ]


def told(trials: int, folder: str) -> None:
    """Print the seconds of CPU from a journal to a page and to read the journal again, peak in MiB, journal in MB."""
    out = Path(folder)
    design = Design.of(short_spiral(), select_calibrators(tuple(CALIBRATORS)[:CALIBRATORS_COMPARED]), seed=1)
    _write_journal(design, trials, out)
    begun = time.process_time()
    report(design, out)
    taken_s = time.process_time() - begun
    Journal.open(out, design.identity()).columns(trials)
    again_s = time.process_time() - begun - taken_s
    status = dict(line.split(":", 1) for line in Path("/proc/self/status").read_text().splitlines())
    print(taken_s, again_s, int(status["VmHWM"].split()[0]) / 1024, (out / "journal.jsonl").stat().st_size / 1e6)


def report(design: Design, out: Path) -> str:
    """Read a finished journal, write the table, and return the page."""
    table = TrialTable.of_columns(design, Journal.open(out, design.identity()).columns(TRIALS))
    table.write(out)
    first = rank_calibrators(table, score_definition(RANKED_BY))
    reference = first.best.calibrator
    return comparison_page(Comparison("report", table, (first,), first.sentence, reference, "No trial is recorded."))


def _write_journal(design: Design, trials: int, out: Path) -> None:
    """Append trials whose calibrators past FITTING do not apply, as on a run without the channels that those need."""
    rng = np.random.default_rng(1)
    with Journal.open(out, design.identity()).path.open("ab") as file:
        for run in range(trials):
            scores = iter(rng.uniform(size=(FITTING + 1, len(COLUMNS))).tolist())
            found = tuple(
                TrialRow(name, "ok", "", dict(zip(COLUMNS, next(scores), strict=True)), 0.1, 0.1)
                if number < FITTING or name == UNCORRECTED
                else TrialRow(name, "not_applicable", "the recording has no attitude", {}, 0.0, 0.0)
                for number, name in enumerate(design.calibrators)
            )
            file.write(sealed(json.dumps(asdict(Trial(0, run, found)), separators=(",", ":"))))
