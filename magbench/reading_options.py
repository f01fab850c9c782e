"""The options that say how a log is read, for every command that takes one."""

from __future__ import annotations

import functools
import inspect
from collections.abc import Callable, Sequence
from pathlib import Path
from types import SimpleNamespace
from typing import TYPE_CHECKING, Annotated, Any, get_type_hints

import typer

if TYPE_CHECKING:
    from recordings.reading import Reading

READING = "reading"
"""The parameter of a command that takes the options."""
OPTIONS: dict[str, Any] = {
    "maps": Annotated[
        list[str] | None, typer.Option("--map", help="Rename and convert a column, e.g. --map mag_x_nT=bx,unit=uT")
    ],
    "mag": Annotated[str | None, typer.Option("--mag", metavar="X,Y,Z", help="The magnetometer's columns of a log.")],
    "unit": Annotated[
        str | None, typer.Option("--unit", help="Unit of the magnetometer's columns: nT, uT, mG, G, ..., count.")
    ],
    "axes": Annotated[
        str | None,
        typer.Option("--axes", metavar="A,B,C", help="The log's axes that form x,y,z of the body, e.g. y,x,-z."),
    ],
    "frame": Annotated[
        str | None, typer.Option("--frame", help="Body frame of the log: flu, or frd, which is turned to flu.")
    ],
    "place": Annotated[
        str | None,
        typer.Option("--place", metavar="LAT,LON", help="Where, degrees[, m]: with --date gives the field vector."),
    ],
    "date": Annotated[str | None, typer.Option("--date", metavar="DATE", help="When, e.g. 2024-05-01.")],
    "stream": Annotated[
        str | None, typer.Option("--stream", help="Word that marks the magnetometer's rows among other sensors'.")
    ],
    "forget": Annotated[bool, typer.Option("--forget", help="Remove the options that are kept beside the log.")],
}
"""By the name of the field in Reading; `forget` speaks of the file that keeps them."""


def reads_logs(data: str, *, notes: bool = True) -> Callable[[Callable[..., None]], Callable[..., None]]:
    """Give a command the options of OPTIONS in place of its parameter `reading`.

    data : the command's parameter with the path of the log, or several. How each log was read is printed to standard
    error after the answer, and not beside a refusal, which is one line; without notes, the command prints it itself.
    Stated options are kept beside the log.
    """

    def with_options(command: Callable[..., None]) -> Callable[..., None]:
        @functools.wraps(command)
        def wrapped(**given: Any) -> None:
            from magbench.console import say
            from recordings.reading import Reading, listening

            said = {name: given.pop(name) for name in OPTIONS}
            logs = _files(given[data])
            if said.pop("forget"):
                _forget(logs)
            reading = Reading(**{name: value for name, value in said.items() if value is not None})
            told: list[str] = []
            with listening(told.append if notes else lambda line: None):
                try:
                    command(**given, reading=reading)
                except typer.Exit:
                    _conclude(reading, logs, told, say)
                    raise
                _conclude(reading, logs, told, say)

        signature = _signature(command)
        wrapped.__signature__ = signature  # type: ignore[attr-defined]
        wrapped.__annotations__ = {p.name: p.annotation for p in signature.parameters.values()}
        return wrapped

    return with_options


def _signature(command: Callable[..., None]) -> inspect.Signature:
    """Return the command's signature with the options after its own, in place of the reading."""
    texts = {name: text for name, text in command.__annotations__.items() if name not in (READING, "return")}
    hints = get_type_hints(SimpleNamespace(__annotations__=texts), command.__globals__, include_extras=True)
    parameters = []
    for name, parameter in inspect.signature(command).parameters.items():
        if name != READING:
            parameters.append(_keyword(name, hints[name], parameter.default))
    options = [_keyword(name, hint, False if name == "forget" else None) for name, hint in OPTIONS.items()]
    return inspect.Signature([*parameters, *options])


def _keyword(name: str, hint: Any, default: Any) -> inspect.Parameter:
    return inspect.Parameter(name, inspect.Parameter.KEYWORD_ONLY, default=default, annotation=hint)


def _files(data: str | Path | Sequence[Path] | None) -> list[Path]:
    """Return the logs among the paths: files, no scenarios."""
    paths = data if isinstance(data, list | tuple) else [data] if data else []
    return [path for path in map(Path, paths) if path.is_file() and path.suffix != ".toml"]


def _forget(logs: Sequence[Path]) -> None:
    from recordings.files import system_errors_about
    from recordings.reading import kept_file

    for file in map(kept_file, logs):
        with system_errors_about(file):
            file.unlink(missing_ok=True)


def _conclude(reading: Reading, logs: Sequence[Path], told: Sequence[str], say: Callable[[str], None]) -> None:
    """Print how the logs were read; keep stated options beside them, and say so."""
    from recordings.reading import kept_file

    for line in told:
        say(line)
    kept = [kept_file(log) for log in logs if reading and reading.keep(log)]
    if kept:
        say(f"options kept in {', '.join(map(str, kept))} for the next time (--forget removes them)")
