"""The directory of numba's compiled loops; few imports here, since every start of the program runs this module."""

from __future__ import annotations

import os
import sys


def ensure_numba_cache() -> None:
    """Give numba a temporary directory of this process where numba would find no writable directory and fail.

    Numba keeps compiled code next to the package, else in the user's cache. A read-only installation run by a user
    without a home, as in containers, has neither. Called before numba is imported; workers inherit the choice.
    """
    package = os.path.join(os.path.dirname(__file__), "__pycache__")
    home = os.path.join(os.environ.get("XDG_CACHE_HOME") or os.path.expanduser("~/.cache"), "numba")
    if "NUMBA_CACHE_DIR" in os.environ or _writable(package) or _writable(home):
        return
    folder = _private()
    os.environ["NUMBA_CACHE_DIR"] = folder
    if "numba" in sys.modules:
        sys.modules["numba"].config.CACHE_DIR = folder


def _writable(folder: str) -> bool:
    try:
        os.makedirs(folder, exist_ok=True)
    except OSError:
        return False
    return os.access(folder, os.W_OK | os.X_OK)


def _private() -> str:
    """Return a new directory for this user alone, removed when the process ends."""
    import atexit
    import shutil
    import tempfile

    folder = tempfile.mkdtemp(prefix="magbench-")
    atexit.register(shutil.rmtree, folder, ignore_errors=True)
    return folder
