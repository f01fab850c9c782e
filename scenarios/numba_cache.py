"""Where numba keeps the compiled loops of every package; it imports little, since every start of the program does."""

from __future__ import annotations

import os
import sys


def ensure_numba_cache() -> None:
    """Give numba a directory of this process where it would find none that can be written, and would refuse to start.

    It keeps compiled code beside the package, else in the user's cache. A read-only installation run by a user without
    a home, as in containers, has neither. Called before numba is imported; workers inherit the choice.
    """
    beside = os.path.join(os.path.dirname(__file__), "__pycache__")
    home = os.path.join(os.environ.get("XDG_CACHE_HOME") or os.path.expanduser("~/.cache"), "numba")
    if "NUMBA_CACHE_DIR" in os.environ or _writable(beside) or _writable(home):
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
    """A directory that this user alone can read, removed when the process ends."""
    import atexit
    import shutil
    import tempfile

    folder = tempfile.mkdtemp(prefix="magbench-")
    atexit.register(shutil.rmtree, folder, ignore_errors=True)
    return folder
