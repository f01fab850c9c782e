"""`magbench show`: open a recording in the rerun viewer."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from magbench.options import Json
from scenarios.errors import InputError


def command(
    path: Annotated[Path, typer.Argument(metavar="FILE", help="A recording.rrd, or a directory that holds one.")],
    web: Annotated[bool, typer.Option("--web", help="Serve it to a browser on this machine instead.")] = False,
    json: Json = False,
) -> None:
    """Open a recording in the rerun viewer.

    Example: magbench show out/auv-dive
    """
    file = path / "recording.rrd" if path.is_dir() else path
    if not file.is_file():
        raise InputError("there is no recording", where=str(file), do="`magbench run SCENARIO` writes one")
    if file.suffix != ".rrd":
        raise InputError("is not a rerun recording (.rrd)", where=str(file), do="`magbench run SCENARIO` writes one")
    from magbench.console import emit
    from magbench.viewer import view

    view(file, web=web)
    if json:
        emit({"file": str(file)})
