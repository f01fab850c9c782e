"""The files that a newcomer meets: version, targets and hooks are those of the project."""

from __future__ import annotations

import re
import subprocess

import pytest

import magbench
from tests.conftest import ROOT
from tests.text_files import main, with_one_end

TEXTS = {".py", ".md", ".toml", ".txt", ".yml", ".yaml", ".cff", ".xml", ".html", ".js", ".css", ".csv", ".json"}
DIALECTS = "tests/recordings/cases/"
"""Logs whose encodings and line ends are what the tests of the readers are about."""


def text(name: str) -> str:
    return (ROOT / name).read_text(encoding="utf-8")


def test_the_citation_and_the_changelog_have_the_version() -> None:
    citation = text("CITATION.cff")
    (released,) = re.findall(r"^date-released: (.*)$", citation, re.MULTILINE)
    assert f"\nversion: {magbench.__version__}\n" in citation
    assert f"\n## {magbench.__version__}, {released}\n" in text("CHANGELOG.md")


def test_the_changelog_has_a_line_for_each_capability() -> None:
    sections = re.findall(r"^## (\w[\w.]*)", text("CHANGELOG.md"), re.MULTILINE)
    assert sections[0] == "Unreleased"
    entries = re.split(r"^- ", text("CHANGELOG.md"), flags=re.MULTILINE)[1:]
    assert not [entry for entry in entries if len(entry.split("\n\n")[0].splitlines()) > 3]


def test_continuous_integration_calls_targets_that_there_are() -> None:
    called = re.findall(r"\bmake (\w+)", text(".github/workflows/ci.yml").replace("# The same make targets", ""))
    assert {"lint", "installed", "gates", "test"} <= set(called)
    assert set(called) <= set(re.findall(r"^([a-z-]+):", text("Makefile"), re.MULTILINE)) | {"targets"}
    assert set(re.findall(r"^make (\w+)", text(".ci/run"), re.MULTILINE)) <= set(called)


def test_every_text_file_ends_with_one_line_break(tmp_path) -> None:  # type: ignore[no-untyped-def]
    tracked = subprocess.run(["git", "ls-files"], cwd=ROOT, capture_output=True, text=True)
    if tracked.returncode:
        pytest.skip("not a git checkout")
    names = [name for name in tracked.stdout.splitlines() if not name.startswith(DIALECTS)]
    files = [ROOT / name for name in names if (ROOT / name).suffix in TEXTS]
    contents = {file: file.read_bytes() for file in files if file.is_file()}
    assert not [str(file) for file, content in contents.items() if with_one_end(content) != content]
    (tmp_path / "a.txt").write_bytes(b"a\n\n\n")
    assert main([str(tmp_path / "a.txt")]) == 1
    assert (tmp_path / "a.txt").read_bytes() == b"a\n"
    assert main([str(tmp_path / "a.txt")]) == 0
