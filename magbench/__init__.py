"""magbench: simulation and synthetic-data test bench for three-axis magnetometer calibration.

>>> import magbench
>>> found = magbench.calibrate([[48_000, 0, 0], [0, 48_000, 0], [0, 0, 48_000]] * 5, 48_000)
>>> found.status.kind
'unobservable'

Functions import what they need when they are called, types when they are first used.
"""

from __future__ import annotations

import os
from typing import TYPE_CHECKING

if not os.path.isdir(os.path.join(os.path.dirname(__file__), "sim")):  # not installed: a checkout
    from magbench.checkout import join

    join()

from magbench.api.apply import apply, apply_file
from magbench.api.bound import bound, what_if
from magbench.api.calibrate import calibrate, register
from magbench.api.compare import compare
from magbench.api.cross_validate import worth
from magbench.api.dataset import dataset
from magbench.api.diagnose import diagnose
from magbench.api.gate import gate, propose_gates, write_baseline
from magbench.api.inspect import inspect
from magbench.api.plan import plan
from magbench.api.read import read
from magbench.api.recheck import recheck
from magbench.api.reproduce import reproduce
from magbench.api.run import run
from magbench.api.simulate import simulate
from scenarios.errors import InputError

if TYPE_CHECKING:
    from calib.base import Calibrator
    from calib.reference import Reference
    from calib.result import Calibration, Status
    from diagnosis.result import Diagnosis
    from recordings import Reading, Recording, Truth, read_recording, read_run
    from reports.outputs.run import run_scenario
    from scenarios.load import catalogue
    from sim.dataset_writer import generate
    from sim.scenario import Scenario, load
    from validation.inspection.inspection import Inspection
    from validation.scoring.outcome import Outcome

__version__ = "0.1.0"
__all__ = [
    "Calibration",
    "Calibrator",
    "Diagnosis",
    "InputError",
    "Inspection",
    "Outcome",
    "Reading",
    "Recording",
    "Reference",
    "Scenario",
    "Status",
    "Truth",
    "apply",
    "apply_file",
    "bound",
    "calibrate",
    "catalogue",
    "compare",
    "dataset",
    "diagnose",
    "gate",
    "generate",
    "inspect",
    "load",
    "plan",
    "propose_gates",
    "read",
    "read_recording",
    "read_run",
    "recheck",
    "register",
    "reproduce",
    "run",
    "run_scenario",
    "simulate",
    "what_if",
    "worth",
    "write_baseline",
]

if not TYPE_CHECKING:  # type checkers read the imports above
    _LATER = {
        "Calibration": "magbench.calib.result",
        "Calibrator": "magbench.calib.base",
        "Diagnosis": "magbench.diagnosis.result",
        "Inspection": "magbench.validation.inspection.inspection",
        "Outcome": "magbench.validation.scoring.outcome",
        "Reading": "magbench.recordings",
        "Recording": "magbench.recordings",
        "Reference": "magbench.calib.reference",
        "Scenario": "magbench.sim.scenario",
        "Status": "magbench.calib.result",
        "Truth": "magbench.recordings",
        "catalogue": "magbench.scenarios.load",
        "generate": "magbench.sim.dataset_writer",
        "load": "magbench.sim.scenario",
        "read_recording": "magbench.recordings",
        "read_run": "magbench.recordings",
        "run_scenario": "magbench.reports.outputs.run",
    }

    def __getattr__(name):
        from importlib import import_module

        if name not in _LATER:
            raise AttributeError(f"magbench has no {name!r}; it has {', '.join(__all__)}")
        return getattr(import_module(_LATER[name]), name)

    def __dir__():
        return [*__all__, "__version__"]
