"""magbench: simulation and synthetic-data test bench for three-axis magnetometer calibration.

Public names, imported on first use:

>>> import magbench
>>> sorted(name for name in magbench.__all__)[:4]
['Calibration', 'Outcome', 'Recording', 'Reference']
"""

from __future__ import annotations

import importlib
from importlib.util import find_spec
from pathlib import Path
from typing import Any

_PUBLIC = {
    "Calibration": "calib.result",
    "Outcome": "validation.scoring.outcome",
    "Recording": "sim.dataset",
    "Reference": "calib",
    "Scenario": "scenarios.spec",
    "Truth": "sim.dataset",
    "catalogue": "scenarios.load",
    "generate": "sim.generate",
    "load_checked": "sim.scenario",
    "read_recording": "sim.dataset",
    "read_run": "sim.dataset",
    "run_scenario": "validation.outputs.run",
}
__all__ = sorted(_PUBLIC)


def __getattr__(name: str) -> Any:
    if name not in _PUBLIC:
        raise AttributeError(f"magbench has no {name!r}; it has {', '.join(_PUBLIC)}")
    return getattr(importlib.import_module(_PUBLIC[name]), name)


def __dir__() -> list[str]:
    return __all__


def _check_own_packages() -> None:
    """The packages beside this one have short names: say so plainly where another distribution shadows one."""
    home = Path(__file__).resolve().parent.parent
    for name in ("scenarios", "sim", "calib", "validation"):
        spec = find_spec(name)
        place = Path(spec.origin).resolve().parent if spec and spec.origin else None
        if place != home / name:
            raise ImportError(
                f"magbench needs its own package {name!r} in {home}, but Python finds {place}: another package of that "
                "name shadows it; use a virtual environment of its own, or start from another directory"
            )


_check_own_packages()
