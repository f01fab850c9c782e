"""The calibrators load neither the simulator nor its engine."""

from __future__ import annotations

import subprocess
from collections.abc import Callable

LOAD_ALL = """
import importlib, pkgutil, sys
import calib
for module in pkgutil.walk_packages(calib.__path__, "calib."):
    importlib.import_module(module.name)
print(*sorted(name for name in sys.modules if name.split(".")[0] in ("sim", "mujoco")))
"""


def test_no_module_of_calib_loads_sim_or_mujoco(run_python: Callable[[str], subprocess.CompletedProcess[str]]) -> None:
    ended = run_python(LOAD_ALL)
    assert (ended.returncode, ended.stdout.strip()) == (0, ""), ended.stderr
