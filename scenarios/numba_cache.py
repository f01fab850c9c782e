"""Where numba keeps the compiled loops."""

from __future__ import annotations

import atexit
import os
import shutil
import sys
import tempfile
from pathlib import Path


def keep_somewhere() -> None:
    """Give numba a directory of this process where it would find none that can be written, and would refuse to start.

    It keeps compiled code beside the package, else in the user's cache. A read-only installation run by a user without
    a home, as in containers, has neither. Called before numba is imported; workers inherit the choice.
    """
    home = Path(os.environ.get("XDG_CACHE_HOME") or Path("~/.cache").expanduser()) / "numba"
    if "NUMBA_CACHE_DIR" in os.environ or any(map(_writable, (Path(__file__).parent / "__pycache__", home))):
        return
    folder = tempfile.mkdtemp(prefix="magbench-")
    atexit.register(shutil.rmtree, folder, ignore_errors=True)
    os.environ["NUMBA_CACHE_DIR"] = folder
    if "numba" in sys.modules:
        sys.modules["numba"].config.CACHE_DIR = folder


def _writable(folder: Path) -> bool:
    try:
        folder.mkdir(parents=True, exist_ok=True)
        with tempfile.TemporaryFile(dir=folder):
            return True
    except OSError:
        return False
