"""The project's docstrings as Sphinx reads them: `name : text` becomes a field of the page, signs become plain text."""

from __future__ import annotations

import inspect
import re
from collections.abc import Iterator, Mapping

FIELD = re.compile(r"^(\*{0,2}\w+(?:, \w+)*) : ")
CONTINUED = re.compile(r"\n[ \t]+")
INSIDE = re.compile(r"(?<=[.;]) +(?=\w+(?:, \w+)* : )")
"""Where a line goes on with the next name."""
LITERAL = re.compile(r"(``.+?``|`.+?`)")
SIGNS = re.compile(r"([*|\\]|_(?=\W|$))")
"""What reStructuredText would take for emphasis, a substitution or a link."""


def process(_app: object, _what: str, _name: str, thing: object, _options: object, lines: list[str]) -> None:
    """Rewrite a docstring in place, as `autodoc-process-docstring` asks."""
    lines[:] = list(rewritten(lines, types_of(thing)))


def types_of(thing: object) -> dict[str, str]:
    """The annotation of each argument as it is written; none for what cannot be called."""
    try:
        arguments = inspect.signature(thing).parameters if callable(thing) else {}
    except ValueError:
        arguments = {}
    return {name: one.annotation for name, one in arguments.items() if isinstance(one.annotation, str)}


def rewritten(lines: list[str], types: Mapping[str, str]) -> Iterator[str]:
    """The lines of a docstring, its examples as they are."""
    for paragraph in re.split(r"\n\s*\n", "\n".join(lines)):
        if paragraph.lstrip().startswith(">>>"):
            yield paragraph
        else:
            yield from _paragraph(paragraph, types)
        yield ""


def _paragraph(text: str, types: Mapping[str, str]) -> Iterator[str]:
    """Its words in one line, or a field a name with the words before them."""
    before, fields = "", []
    for line in (part for whole in CONTINUED.sub(" ", text).splitlines() for part in INSIDE.split(whole)):
        if found := FIELD.match(line):
            fields.append([found[1], line[found.end() :]])
        elif fields:
            fields[-1][1] += " " + line.strip()
        else:
            before += line.strip() + " "
    yield escaped(before.strip())
    if fields:
        yield ""
    for names, words in fields:
        first, *others = names.replace("*", "").split(", ")
        yield from _field(first, escaped(words), types)
        for other in others:
            yield from _field(other, f"see `{first}`", types)


def _field(name: str, words: str, types: Mapping[str, str]) -> Iterator[str]:
    yield f":param {escaped(name)}: {words}"
    if name in types:
        yield f":type {escaped(name)}: {types[name]}"


def escaped(text: str, signs: re.Pattern[str] = SIGNS) -> str:
    """Signs outside of literals marked as signs."""
    parts = LITERAL.split(text)
    return "".join(part if part.startswith("`") else signs.sub(r"\\\1", part) for part in parts)
