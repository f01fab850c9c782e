"""Pages whose blocks run while the site is built: what a command prints and what a snippet draws stand below each.

`sh`: commands of magbench. `python`: one snippet after another with the same names; a figure or a value at the end of
a block is shown, as a notebook does. `toml` and `yaml` that begin with `# name` are files of the reader's.
"""

from __future__ import annotations

import ast
import contextlib
import io
import os
import re
import shlex
import shutil
import sys
import tempfile
import textwrap
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Any

from matplotlib.figure import Figure
from pandas import DataFrame

from magbench.cli import main
from reports.plots.style import styled

if TYPE_CHECKING:
    from sphinx.application import Sphinx

EXECUTED = "tutorials/"
"""Where these pages are."""
FENCE = re.compile(r"^```(\w+)\n(.*?)^```\n", re.MULTILINE | re.DOTALL)
PROGRESS = re.compile(r"\d %$|[:,] \d+ s$|^diagnosis: ")
NAMED = re.compile(r"# (\S+\.\w+)\n")
COLUMNS, MOST_LINES, FEW_LINES, DPI = 92, 26, 18, 110
ROOT = Path(__file__).parent.parent
LINKED = ("docs", "examples")
"""Folders of the repository that the commands name."""


def source_read(app: Sphinx, page: str, source: list[str]) -> None:
    """Sphinx's event: run the blocks of a page."""
    if page.startswith(EXECUTED) and not page.endswith("/index"):
        source[0] = executed(source[0], Path(app.srcdir), page)


def executed(text: str, site: Path, page: str) -> str:
    """The text with what its blocks print and draw; ValueError for a command that fails."""
    with tempfile.TemporaryDirectory() as folder, contextlib.chdir(folder), narrow(), importable(folder):
        for name in LINKED:
            Path(name).symlink_to(ROOT / name)
        session = Session(site, page)
        return FENCE.sub(lambda found: found[0] + session.run(found[1], found[2]), text)


@contextlib.contextmanager
def narrow() -> Iterator[None]:
    """Tables as wide as the page."""
    old = os.environ.get("COLUMNS")
    os.environ["COLUMNS"] = str(COLUMNS)
    try:
        yield
    finally:
        os.environ.pop("COLUMNS")
        if old is not None:
            os.environ["COLUMNS"] = old


@contextlib.contextmanager
def importable(folder: str) -> Iterator[None]:
    """The reader's files can be imported, as in a shell there."""
    sys.path.insert(0, folder)
    try:
        yield
    finally:
        sys.path.remove(folder)


class Notes(io.StringIO):
    """Standard error as a page shows it: each line once a page, without progress."""

    def __init__(self, shown: io.StringIO, known: set[str]) -> None:
        super().__init__()
        self._shown, self._known = shown, known

    def write(self, text: str) -> int:
        """Pass the lines on that are new."""
        for line in text.splitlines():
            if line and line not in self._known and not PROGRESS.search(line):
                self._shown.write("\n".join(textwrap.wrap(line, COLUMNS)) + "\n")
                self._known.add(line)
        return len(text)


@dataclass
class Session:
    """One page being run: the site's source, the page's name, its snippets' names, how much was made, notes told."""

    site: Path
    page: str
    names: dict[str, Any] = field(default_factory=lambda: {"__name__": "snippet"})
    made: int = 0
    noted: set[str] = field(default_factory=set)

    def run(self, language: str, code: str) -> str:
        """What stands below a block."""
        if named := NAMED.match(code):
            Path(named[1]).parent.mkdir(parents=True, exist_ok=True)
            Path(named[1]).write_text(code, encoding="utf-8")
        match language:
            case "sh":
                lines = (line for line in code.replace("\\\n", " ").splitlines() if line.strip())
                return "".join(self._command(line) for line in lines)
            case "python":
                return self._snippet(code)
        return ""

    def _command(self, line: str) -> str:
        program, *arguments = shlex.split(line)
        told = io.StringIO()
        with contextlib.redirect_stdout(told), contextlib.redirect_stderr(Notes(told, self.noted)):
            status = main(arguments) if program == "magbench" else None
        if status != 0:
            raise ValueError(f"{self.page}: {line}\n{told.getvalue()}")
        return printed(told.getvalue()) + self._report(arguments)

    def _report(self, arguments: list[str]) -> str:
        """A link to the page that a command wrote."""
        out = Path(arguments[arguments.index("-o") + 1]) if "-o" in arguments else None
        pages = [] if out is None else [out / "report.html", out.with_suffix(".html")]
        page = next((one for one in pages if one.is_file()), None)
        if page is None:
            return ""
        name = f"pages/{self._next()}.html"
        (self.site / "extra" / "pages").mkdir(parents=True, exist_ok=True)
        shutil.copyfile(page, self.site / "extra" / name)
        return f'\n<a href="../{name}">The page that this command wrote: {page}</a>\n'

    def _snippet(self, code: str) -> str:
        tree = ast.parse(code)
        last = tree.body.pop() if isinstance(tree.body[-1], ast.Expr) else None
        with contextlib.redirect_stdout(io.StringIO()) as told, styled():
            exec(compile(tree, self.page, "exec"), self.names)
            value = eval(compile(ast.Expression(last.value), self.page, "eval"), self.names) if last else None
            picture = self._picture(value, ast.unparse(last)) if last and isinstance(value, Figure) else ""
            if value is not None and not picture:
                print(value.to_string() if isinstance(value, DataFrame) else value)
        return printed(told.getvalue()) + picture

    def _picture(self, figure: Figure, call: str) -> str:
        """A figure as a file beside the page."""
        name = f"pictures/{self._next()}.png"
        (self.site / EXECUTED / "pictures").mkdir(exist_ok=True)
        figure.savefig(self.site / EXECUTED / name, dpi=DPI)
        return f"\n![`{call}`]({name})\n"

    def _next(self) -> str:
        self.made += 1
        return f"{self.page.removeprefix(EXECUTED)}-{self.made}"


def printed(text: str) -> str:
    """What was printed, as a block; of much the first lines, and all on request."""
    lines = [line.rstrip() for line in text.strip("\n").splitlines()]
    if not lines:
        return ""
    if len(lines) <= MOST_LINES:
        return block(lines)
    first = max((k for k, line in enumerate(lines[:FEW_LINES]) if not line), default=FEW_LINES)
    return f"{block(lines[:first])}\n::::{{dropdown}} All {len(lines)} lines{block(lines)}::::\n"


def block(lines: Sequence[str]) -> str:
    """Lines as they are."""
    return "\n```text\n" + "\n".join(lines) + "\n```\n"
