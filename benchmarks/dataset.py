"""`simulate` against the physics, of one long run and of a fleet's, and its memory against the length of the run.

Half an hour with 32 effects takes 1.20 times the bare physics, a quarter of an hour 1.15 to 1.38, on a busy machine.
Beside 0.63 s of physics a profile of the quarter shows: the effects 0.09, their columns copied into row groups 0.05,
Parquet's encoding 0.10, the rest manifest and checksums, which do not grow with the run. Without labels: 1.03 to 1.14.
A fleet's run, another vehicle and dive each, takes 1.06 to 1.19 times the motion: 0.5 s of CPU and 2.7 MB, so that 1e6
runs take 140 hours of one core, or nine minutes of 1000 workers and 2.7 TB.
"""

from __future__ import annotations

import subprocess
import sys
import tempfile
from itertools import count
from pathlib import Path

from benchmarks.closed_loop import bare_steps, commands
from benchmarks.measure import Row, paired_ratio
from sim.dataset_writer import generate
from sim.effects import EFFECTS, Effects
from sim.scenario import Scenario, load
from sim.simulation import channels_of, plan, true_motion
from sim.state import MOTION

MOST_COST, MOST_FLEET = 1.4, 1.25
FLEET, SMALL_FLEET = 8, 1
"""Runs of the fleet; the second is for a test of the benchmark."""
MOST_GROWTH_MIB = 100.0
HOUR_S = 3600.0
HOURS, SMALL_H = (1.0, 20.0), (0.015, 0.02)
"""Lengths of the short and the long run; the second pair is for a test of the benchmark."""


def every_effect(hours: float) -> Scenario:
    """An AUV spiral at 50 Hz with every effect that its channels allow, each with values under which it acts."""
    base = load("auv-spiral", [f"phases.0.duration_s={HOUR_S * hours}", "sampling.rate_hz=50"])
    there = {*MOTION, *channels_of(base.vehicle.kind)}
    effects = {cls.name: dict(cls.example) for cls in EFFECTS if there.issuperset(cls.needs)}
    return base.model_copy(update={"effects": Effects(effects)})


def rows(small: bool = False) -> list[Row]:
    """Return the cost of an hour with every effect and of a fleet, and the growth of memory from one hour to twenty."""
    hours = SMALL_H if small else HOURS
    with tempfile.TemporaryDirectory() as folder:
        fleet = _fleet(SMALL_FLEET if small else FLEET, Path(folder))
        return [_cost(hours[0], Path(folder)), fleet, _growth(hours, Path(folder))]


def _cost(hours: float, folder: Path) -> Row:
    scenario, number = every_effect(hours), count()
    simulate = lambda: generate(scenario, folder / f"run{next(number)}")  # noqa: E731
    ratio, top, bottom = paired_ratio(simulate, bare_steps(scenario, commands(scenario)), pairs=3)
    note = f"{hours:g} h at 50 Hz, {len(EFFECTS)} effects: {top:.2f} s, bare physics {bottom:.2f} s"
    return Row("simulate and write / bare physics", ratio, MOST_COST, False, note)


def _fleet(runs: int, folder: Path) -> Row:
    scenario, number = load("auv-fleet"), count()
    simulate = lambda: generate(scenario, folder / f"fleet{next(number)}", runs=runs)  # noqa: E731
    ratio, top, bottom = paired_ratio(simulate, lambda: _motions(scenario, runs), pairs=3)
    note = f"{runs} runs of {scenario.name}: {top / runs:.2f} s of CPU each, motion {bottom / runs:.2f} s"
    return Row("simulate and write a fleet / motions", ratio, MOST_FLEET, False, note)


def _motions(scenario: Scenario, runs: int) -> None:
    for run in range(runs):
        for _ in true_motion(plan(scenario, run, scenario.seed)):
            pass


def _growth(hours: tuple[float, float], folder: Path) -> Row:
    short, long = (_peak_MiB(length, folder) for length in hours)
    note = f"peak of a {hours[0]:g} h run {short:.0f} MiB, of a {hours[1]:g} h run {long:.0f} MiB"
    return Row("growth of peak memory, MiB", long - short, MOST_GROWTH_MIB, False, note)


def _peak_MiB(hours: float, folder: Path) -> float:
    code = (
        "import sys; from pathlib import Path\n"
        "from benchmarks.dataset import every_effect; from sim.dataset_writer import generate\n"
        f"generate(every_effect({hours}), Path(sys.argv[1]))\n"
        "lines = dict(line.split(':', 1) for line in open('/proc/self/status'))\n"
        "print(int(lines['VmHWM'].split()[0]) / 1024)"  # getrusage would tell this process's own peak, inherited
    )
    command = [sys.executable, "-c", code, str(folder / f"peak{hours}")]
    return float(subprocess.run(command, capture_output=True, text=True, check=True).stdout)
