"""magbench: simulation and synthetic-data test bench for three-axis magnetometer calibration.

Public names, imported on first use:

>>> import magbench
>>> sorted(name for name in magbench.__all__)[:4]
['Calibration', 'Outcome', 'Recording', 'Reference']
"""

from __future__ import annotations

import importlib
import os
from typing import Any

__version__ = "0.1.0"
_PUBLIC = {
    "Calibration": "magbench.calib.result",
    "Outcome": "magbench.validation.scoring.outcome",
    "Recording": "magbench.sim.dataset",
    "Reference": "magbench.calib",
    "Scenario": "magbench.sim.scenario",
    "Truth": "magbench.sim.dataset",
    "catalogue": "magbench.scenarios.load",
    "generate": "magbench.sim.generate",
    "load": "magbench.sim.scenario",
    "read_recording": "magbench.sim.dataset",
    "read_run": "magbench.sim.dataset",
    "run_scenario": "magbench.validation.outputs.run",
}
__all__ = sorted(_PUBLIC)


def __getattr__(name: str) -> Any:
    if name not in _PUBLIC:
        raise AttributeError(f"magbench has no {name!r}; it has {', '.join(_PUBLIC)}")
    return getattr(importlib.import_module(_PUBLIC[name]), name)


def __dir__() -> list[str]:
    return __all__


if not os.path.isdir(os.path.join(os.path.dirname(__file__), "sim")):  # not installed: a checkout
    from magbench.checkout import join

    join()
