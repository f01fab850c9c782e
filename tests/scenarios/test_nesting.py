"""Scenario files and JSON that nest deep or hold very many values are refused before memory is taken for them."""

from __future__ import annotations

import tracemalloc
from pathlib import Path

import pytest

from recordings.reading import Reading
from scenarios.errors import MOST_LETTERS, InputError
from scenarios.files import MOST_JSON_VALUES, parsed_json
from scenarios.load import load
from scenarios.nesting import MOST_LEVELS, MOST_PARTS, MOST_TOML_BYTES, is_nested_deep, parsed_toml
from scenarios.overrides import parse
from scenarios.spec import BaseScenario

DEEP = {
    "a key": ".".join("a" * 20_000) + " = 1",
    "a header": "[" + ".".join("a" * 20_000) + "]",
    "a quoted key": '"x".' * 20_000 + "x = 1",
    "a key with blanks": " . ".join("a" * 20_000) + " = 1",
    "arrays": "a = " + "[" * 20_000,
    "tables": "a = " + "{a = " * 20_000,
    "behind a string": 's = """ \\""" # " """\na = ' + "[" * 20_000,
    "behind an apostrophe": "s = '''a''b'''\n# it's a comment\na = " + "[" * 20_000,
}
PLAIN = {
    "dots in strings": 'a = "' + "." * 100 + '"',
    "brackets in strings": 'a = """' + "[" * 100 + '\n"""\nb = \'' + "{" * 100 + "'",
    "brackets in comments": "# " + "[." * 100 + "\na = 1",
    "numbers": "a = [" + "1.5, " * 100 + "]",
    "arrays beside each other": "a = [" + "[1.0, 2.0], " * 100 + "]",
    "a key of as many parts as are read": ".".join("a" * MOST_PARTS) + " = 1",
    "as many levels as are read": "a = " + "[" * MOST_LEVELS + "]" * MOST_LEVELS,
}


@pytest.mark.parametrize("text", DEEP.values(), ids=DEEP)
def test_deep_nesting_is_refused_with_little_memory(text: str) -> None:
    tracemalloc.start()
    with pytest.raises(InputError, match="nested too deep"):
        parsed_toml(text, "file", "give a scenario file")
    peak = tracemalloc.get_traced_memory()[1]
    tracemalloc.stop()
    assert peak < 2_000_000  # the parser takes 400 MB for a key of 20,000 parts


@pytest.mark.parametrize("text", PLAIN.values(), ids=PLAIN)
def test_what_is_not_nested_is_read(text: str) -> None:
    assert not is_nested_deep(text)
    assert parsed_toml(text, "file", "")


@pytest.mark.parametrize("text", ['"' * 200_000, '"""a\\' * 40_000, "'''a''" * 40_000], ids=["quotes", "escapes", "'"])
def test_strings_that_do_not_end_are_passed_once(text: str) -> None:
    assert not is_nested_deep(text)


def test_every_door_for_toml_counts_first(tmp_path: Path) -> None:
    key = ".".join("a" * 4000)
    (tmp_path / "s.toml").write_text(f"{key} = 1")
    with pytest.raises(InputError, match="nested too deep"):
        load(tmp_path / "s.toml", BaseScenario)
    (tmp_path / "log.csv.magbench.toml").write_text(f"{key} = 1")
    with pytest.raises(InputError, match=r"log\.csv\.magbench\.toml: cannot be used: .*nested too deep"):
        Reading.kept_beside(tmp_path / "log.csv")
    with pytest.raises(InputError, match="not a dotted key"):
        parse(f"{key}=1")
    with pytest.raises(InputError, match="nested too deep"):
        parse(f"a={{{key}=1}}")


def test_a_long_toml_file_is_refused() -> None:
    with pytest.raises(InputError, match="is longer than 2 MB"):
        parsed_toml("#" * (MOST_TOML_BYTES + 1), "file", "")


@pytest.mark.parametrize("kind", [str, str.encode], ids=["text", "bytes"])
def test_json_of_very_many_values_is_refused(kind: type[str]) -> None:
    with pytest.raises(InputError, match=r"file: more than 5e\+06 values"):
        parsed_json(kind("[" + "[]," * (MOST_JSON_VALUES // 2 + 1) + "0]"), "file", "")


def test_a_message_that_quotes_a_file_stays_short() -> None:
    error = InputError("x" * 3000, where="a file: " + "y" * 40, do="one of: " + "z" * 900)
    assert len(str(error)) == MOST_LETTERS
    assert str(error).startswith("a file: ")
    assert (len(error.what), len(error.do)) == (3000, 908)
    assert str(InputError("x" * 300, where="file", do="y" * 150)) == f"file: {'x' * 300} ({'y' * 150})"
