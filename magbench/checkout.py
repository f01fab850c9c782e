"""In a checkout on the path `magbench.sim` is another name of the module `sim`, which is a folder next to magbench."""

from __future__ import annotations

import os
import sys
from collections.abc import Sequence
from importlib import import_module
from importlib.machinery import ModuleSpec
from importlib.util import find_spec
from types import ModuleType

ROOT = os.path.dirname(os.path.dirname(os.path.abspath(__file__)))


class CheckoutFinder:
    """Finds magbench.sim.field as the module sim.field, before a second module is made from the same file.

    A finder and a loader without their base classes, whose import would take as long as the rest of the start.
    """

    def find_spec(
        self, fullname: str, path: Sequence[str] | None, target: ModuleType | None = None
    ) -> ModuleSpec | None:
        """A spec for the packages of the checkout and their modules, None for all else."""
        own = fullname.removeprefix("magbench.")
        if (
            own == fullname
            or not os.path.isfile(os.path.join(ROOT, own.split(".")[0], "__init__.py"))
            or find_spec(own) is None
        ):
            return None
        return ModuleSpec(fullname, self)  # type: ignore[arg-type]

    def create_module(self, spec: ModuleSpec) -> ModuleType:
        """The plain module; the import system writes `spec` into it, so its own spec is kept for `exec_module`."""
        module = import_module(spec.name.removeprefix("magbench."))
        spec.loader_state = module.__spec__
        return module

    def exec_module(self, module: ModuleType) -> None:
        """Give the plain module, which has run already, its own spec again."""
        assert module.__spec__ is not None
        module.__spec__ = module.__spec__.loader_state


def join() -> None:
    """Make the packages importable under both names, unless an editable installation finds them under one."""
    if find_spec("magbench.sim") is None:
        sys.meta_path.insert(0, CheckoutFinder())
