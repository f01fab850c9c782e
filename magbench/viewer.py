"""Opens the rerun viewer on a recording, served to this machine alone."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

from reports.viewer import viewer_program
from scenarios.errors import InputError


def view(file: Path, *, web: bool = False) -> None:
    """Show a recording in a window, or with `web` in a browser on this machine, until the user ends it.

    Raises InputError where there is no screen for a window.
    """
    if not web and sys.platform == "linux" and not (os.environ.get("DISPLAY") or os.environ.get("WAYLAND_DISPLAY")):
        raise InputError("there is no screen for the viewer's window", where=str(file), do="add --web to use a browser")
    subprocess.run([viewer_program(), str(file), "--bind", "127.0.0.1", *(["--web-viewer"] if web else [])], check=True)
