"""Builds the site in out/site from a copy of docs: `make docs`, without network; the checkout stays as it is.

Versions of the site stand side by side: a copy of out/site beside it, such as out/site-0.1.0, is found by the menu of
every other one (`versions.js` of their folder, which every build writes anew).
"""

from __future__ import annotations

import json
import re
import sys
from collections.abc import Iterator
from pathlib import Path

import reference_pages

import magbench

DOCS = Path(__file__).parent
ROOT = DOCS.parent
PROJECT = ("ARCHITECTURE.md", "CONTRIBUTING.md", "CHANGELOG.md", "REFERENCES.md")
"""Pages of the repository's top that the site holds too, below `project/`."""
ABOVE, BELOW = re.compile(r"\]\(\.\./(?=\w+\.md)"), re.compile(r"\]\(docs/")
"""Links that lead from docs to the top, and back."""
VERSION, VERSIONS = "version.txt", "versions.js"
"""In each site its version, and beside the sites the folder of each version."""
GLOSSARY = re.compile(r"^## Glossary\n(.*?)(?=^## )", re.MULTILINE | re.DOTALL)
"""The words of the architecture, which are those of the pages."""


def main(out: Path = ROOT / "out") -> int:
    """Copy, write the generated pages, and build; a warning fails. The status of Sphinx."""
    from sphinx.cmd.build import main as sphinx

    copy(out / "book")
    options = ("-q", "-W", "--keep-going", "-b", "html", "-d", out / "doctrees", out / "book", out / "site")
    status = sphinx([str(option) for option in options])
    if status == 0:
        list_versions(out / "site")
    return status


def list_versions(site: Path) -> None:
    """Note the site's version in it, and the folders of all versions beside them, as a script that every page loads."""
    (site / VERSION).write_text(magbench.__version__, encoding="utf-8")
    notes = sorted(site.parent.glob(f"*/{VERSION}"))
    folders = {note.parent.name: note.read_text(encoding="utf-8").strip() for note in notes}
    (site.parent / VERSIONS).write_text(f"window.magbenchVersions = {json.dumps(folders)};\n", encoding="utf-8")


def copy(source: Path) -> None:
    """The source of the site; what is as it was keeps its time, pages and examples that are gone are removed."""
    files = {name: path.read_bytes() for name, path in _files()} | {name: text.encode() for name, text in _texts()}
    for name, content in files.items():
        _put(source / name, content)
    (source / "extra").mkdir(exist_ok=True)
    for path in (*source.rglob("*.md"), *source.glob("gallery/*/*")):
        if path.relative_to(source).as_posix() not in files:
            path.unlink()
            (source / "pictures_of" / path.parent.name / f"{path.stem}.rst").unlink(missing_ok=True)


def _files() -> Iterator[tuple[str, Path]]:
    """Every file of docs by its name there."""
    paths = (path for path in DOCS.rglob("*") if path.is_file() and "__pycache__" not in path.parts)
    return ((path.relative_to(DOCS).as_posix(), path) for path in paths)


def _texts() -> Iterator[tuple[str, str]]:
    """Names and texts of pages whose links change, and of generated ones."""
    for path in DOCS.glob("*.md"):
        yield path.name, ABOVE.sub("](project/", path.read_text(encoding="utf-8"))
    for name in PROJECT:
        yield f"project/{name}", BELOW.sub("](../", (ROOT / name).read_text(encoding="utf-8"))
    yield "glossary.md", "# Glossary\n" + GLOSSARY.findall((ROOT / "ARCHITECTURE.md").read_text(encoding="utf-8"))[0]
    yield from reference_pages.pages()


def _put(path: Path, content: bytes) -> None:
    """Write a file whose content is new."""
    if not path.is_file() or path.read_bytes() != content:
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_bytes(content)


if __name__ == "__main__":
    sys.exit(main())
