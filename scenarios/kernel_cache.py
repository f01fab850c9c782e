"""numba's `njit`, which keeps the compiled code of magbench's kernels apart by what their source depends on.

numba looks up compiled code by a function's file, line and bytecode. Two things that change the code are missing there:
a kernel or a type of another file that the function uses, and the name under which a checkout's file is imported
(`sim.rotation` in its tests, `magbench.sim.rotation` elsewhere). Compiled code of magbench therefore lies in a folder
of its file, of the kind of name and of a digest of the sources.
"""

from __future__ import annotations

import hashlib
import os
import re
import shutil
from functools import cache
from glob import escape, glob
from typing import Any

from numba import njit as njit
from numba.core.caching import CacheImpl, InTreeCacheLocator, UserProvidedCacheLocator, UserWideCacheLocator

ROOT = os.path.dirname(os.path.dirname(os.path.abspath(__file__)))
WHOLE = "magbench."
IMPORT = re.compile(rb"^(?:from|import) (?:magbench\.)?([\w.]+)", re.MULTILINE)
KERNEL = re.compile(rb"\b(njit|fast_kernel)\b")


@cache
def digest(module: str) -> str:
    """Return a digest of a module's source, of the modules of this package that it imports, and so on from kernels."""
    total = hashlib.sha256()
    for path in sorted(_sources(module)):
        with open(path, "rb") as file:
            total.update(file.read())
    return total.hexdigest()[:12]


def _sources(module: str) -> set[str]:
    """The files that compiled code of a module can depend on; only a file with kernels hands on what it imports."""
    found: set[str] = set()
    waiting = [module]
    while waiting:
        path = _file(waiting.pop())
        if path is None or path in found:
            continue
        found.add(path)
        with open(path, "rb") as file:
            text = file.read()
        if KERNEL.search(text):
            waiting += [name.decode() for name in IMPORT.findall(text)]
    return found


def _file(module: str) -> str | None:
    """The source of a module, given without `magbench.`; None where it is not of this package."""
    place = os.path.join(ROOT, *module.split("."))
    return next((path for path in (f"{place}.py", os.path.join(place, "__init__.py")) if os.path.isfile(path)), None)


class KernelLocator:
    """For each of numba's places a folder of its own within it; folders of earlier sources are removed."""

    _cache_path: str

    def __init__(self, py_func: Any, py_file: str) -> None:
        super().__init__(py_func, py_file)  # type: ignore[call-arg]
        module = py_func.__module__.removeprefix(WHOLE)
        kind = "nested" if py_func.__module__.startswith(WHOLE) else "plain"
        self._folders = os.path.join(self._cache_path, f"{kind}.{module.rpartition('.')[2]}.")
        self._cache_path = self._folders + digest(module)

    @classmethod
    def from_function(cls, py_func: Any, py_file: str) -> Any:
        """A locator for a kernel of this package where its place can be written, None for all else."""
        if _file(py_func.__module__.removeprefix(WHOLE)) != os.path.abspath(py_file):
            return None
        return super().from_function(py_func, py_file)  # type: ignore[misc]

    def ensure_cache_path(self) -> None:
        """Make the folder, in place of those of earlier sources."""
        if not os.path.isdir(self._cache_path):
            for earlier in glob(f"{escape(self._folders)}*"):
                shutil.rmtree(earlier, ignore_errors=True)
        super().ensure_cache_path()  # type: ignore[misc]


PLACES = (UserProvidedCacheLocator, InTreeCacheLocator, UserWideCacheLocator)
LOCATORS = [type(f"Kernel{place.__name__}", (KernelLocator, place), {}) for place in PLACES]
CacheImpl._locator_classes = [*LOCATORS, *CacheImpl._locator_classes]
