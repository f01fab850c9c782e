"""Pages of the site's reference that the program itself gives: public names, commands, schemas of files."""

from __future__ import annotations

import inspect
import json
import re
from collections.abc import Iterable, Iterator
from typing import Any

from docstrings import escaped
from result_keys import KeyTable, tables, words

import magbench
from magbench.app import program
from magbench.commands.schema import SchemaKind, schema_of
from reports.schemas import MODELS

Page = tuple[str, str]
MARKDOWN = re.compile(r"([|<>*_\[\]\\])")
"""What Markdown would take for a table's bar, a tag, emphasis or a link."""
OPTION = re.compile(r"(?<![\w`-])(--[a-z][\w-]*)(?!`)")


def pages() -> Iterator[Page]:
    """Name and text of every generated page."""
    yield from _api()
    yield from _commands()
    yield from _schemas()


def _api() -> Iterator[Page]:
    """A page for each public name, and their list."""
    names = sorted(magbench.__all__, key=str.lower)
    classes = [name for name in names if inspect.isclass(getattr(magbench, name))]
    functions = [name for name in names if name not in classes]
    for name in names:
        form = "autoclass" if name in classes else "autofunction"
        yield f"api/{name}.md", f"# {name}\n\n{_rst(f'.. {form}:: magbench.{name}')}"
    yield "api/index.md", f"# Python\n\n{_tree(functions, 'Functions')}\n{_tree(classes, 'Classes')}"


def _rst(directive: str) -> str:
    members = "\n   :members:" if "class" in directive else ""
    return f"```{{eval-rst}}\n{directive}{members}\n```\n"


def _tree(names: Iterable[str], caption: str = "", *, hidden: bool = False) -> str:
    """A table of contents."""
    options = f":caption: {caption}\n" * bool(caption) + ":hidden:\n" * hidden
    return f":::{{toctree}}\n:maxdepth: 1\n{options}\n" + "\n".join(names) + "\n:::\n"


def _commands() -> Iterator[Page]:
    """A page for each command, and their list."""
    commands = program().commands
    for name, command in commands.items():
        yield f"commands/{name}.md", _command(name, command)
    rows = "".join(f"| [`{name}`]({name}.md) | {_first(command.help)} |\n" for name, command in commands.items())
    head = "# Commands\n\n| command | what it does |\n|---|---|\n"
    yield "commands/index.md", f"{head}{rows}\n{_tree(commands, hidden=True)}"


def _command(name: str, command: Any) -> str:
    """What a command does, an example, arguments and options."""
    text, _, example = inspect.cleandoc(command.help).partition("Example: ")
    shown = f"## Example\n\n```sh\n{' '.join(example.split())}\n```\n" if example else ""
    rows = "".join(map(_option, command.params))
    table = f"## Arguments and options\n\n| name | value | meaning |\n|---|---|---|\n{rows}"
    return "\n".join([f"# {name}\n", as_markdown(text), shown, table])


def _option(one: Any) -> str:
    """A row of the table."""
    argument = one.param_type_name == "argument"
    name = one.metavar or one.name.upper() if argument else ", ".join(f"`{opt}`" for opt in one.opts)
    value = "" if argument or one.is_flag else one.metavar or _kind(one.type_descriptor.annotation)
    given = isinstance(one.default, str | int | float) and one.default is not False
    said = as_markdown(one.help or "") + (f" Default: {one.default}." if given else "")
    return f"| {name} | {escaped(value, MARKDOWN)} | {said} |\n"


def as_markdown(text: str) -> str:
    """A help text as Markdown, its options as code."""
    return escaped(OPTION.sub(r"`\1`", text), MARKDOWN)


def _kind(annotation: Any) -> str:
    return {"str": "text", "int": "whole number", "float": "number"}.get(getattr(annotation, "__name__", ""), "path")


def _first(text: str | None) -> str:
    """The first sentence of a help text."""
    words = " ".join((text or "").split("\n\n")[0].split())
    return as_markdown(re.split(r"[.;:] ", words, maxsplit=1)[0].rstrip("."))


def _schemas() -> Iterator[Page]:
    """A page each kind of file and result: its keys, and the JSON Schema that `magbench schema` prints."""
    for kind in SchemaKind:
        yield f"schemas/{kind.value}.md", _schema(kind)
    rows = "".join(f"| [`{kind.value}`]({kind.value}.md) | {as_markdown(kind.words)} |\n" for kind in SchemaKind)
    head = "# JSON schemas\n\nEvery file that is read or written, and every `--json`, has a JSON Schema, which\n"
    table = f"`magbench schema KIND` prints.\n\n| KIND | of what |\n|---|---|\n{rows}\n"
    yield "schemas/index.md", head + table + _tree((kind.value for kind in SchemaKind), hidden=True)


def _schema(kind: SchemaKind) -> str:
    """The tables of a result; of what users write, other pages tell the keys, and the schema stands alone."""
    schema = schema_of(kind)
    head = f"# {kind.value}\n\n`magbench schema {kind.value}`: {as_markdown(kind.words)}.\n\n"
    whole = f"```json\n{json.dumps(schema, indent=1, ensure_ascii=False)}\n```\n"
    if kind not in MODELS:
        return head + whole
    return head + "\n".join(map(_keys, tables(schema))) + f"\n::::{{dropdown}} The JSON Schema\n{whole}::::\n"


def _keys(table: KeyTable) -> str:
    """A table of the result with its places, and a row a key."""
    places = ", ".join(f"`{path}`" for path in table.paths if path)
    head = f"## {words(table.name)}\n\n{places}: " if table.name else ""
    rows = "".join(f"| `{name}` | {_linked(kind)} | {as_markdown(said)} |\n" for name, kind, said in table.rows)
    return f"{head}{as_markdown(table.says)}\n\n| key | value | meaning |\n|---|---|---|\n{rows}"


def _linked(kind: str) -> str:
    """A kind of value, the names of inner tables as links to them."""
    return re.sub(r"\\\[(.*?)\\\]", lambda name: f"[{name[1]}](#{name[1].replace(' ', '-')})", escaped(kind, MARKDOWN))
