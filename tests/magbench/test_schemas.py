"""Every result has a schema with a meaning for each key, and what commands print and write is as their schema says."""

from __future__ import annotations

import json
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

import pytest
from jsonschema import Draft202012Validator, ValidationError

from magbench.cli import main
from magbench.commands.schema import SchemaKind, schema_of
from reports.schemas import MODELS
from tests.magbench.test_bad_input import log
from tests.results import check_printed

STILL = "turntable-twelve-stops"
KNOWN = ("--field-strength-nT", "34000")
VARIANTS: tuple[tuple[str, ...], ...] = (
    ("bound", STILL, "--what-if", "noise_std_nT=1,2"),
    ("bound", STILL, "--knowledge", "vector", "--tilt-limits", "20,10"),
    ("calibrate", "log.csv", *KNOWN, "--unit-out", "uT", "--tolerance-deg", "1", "--others", "--worth"),
    ("simulate", STILL, "--runs", "2", "--split", "50/0/50", "--jobs", "1", "-o", "out"),
)
"""Calls with options that add keys."""


def keys(schema: Any) -> Iterator[tuple[str, Mapping[str, Any]]]:
    """Every declared key of a schema."""
    if isinstance(schema, dict):
        properties = schema.get("properties")
        yield from (properties if isinstance(properties, dict) else {}).items()
    for inner in schema.values() if isinstance(schema, dict) else schema if isinstance(schema, list) else ():
        yield from keys(inner)


def test_every_result_is_a_kind() -> None:
    assert {kind.value for kind in SchemaKind} == {*MODELS, "scenario", "gates", "calibration"}


@pytest.mark.parametrize("kind", MODELS)
def test_a_schema_is_valid_and_tells_what_each_key_means(kind: str) -> None:
    schema = schema_of(SchemaKind(kind))
    Draft202012Validator.check_schema(schema)
    assert not [name for name, value in keys(schema) if not value.get("description")]


def test_without_a_kind_all_are_listed(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["schema", "--json"]) == 0
    told = json.loads(capsys.readouterr().out)
    check_printed(["schema"], told)
    assert [one["name"] for one in told["items"]] == [kind.value for kind in SchemaKind]
    assert main(["schema"]) == 0
    assert "diagnose-several" in capsys.readouterr().out


@pytest.mark.parametrize("words", VARIANTS, ids=["-".join(words[::2]) for words in VARIANTS])
def test_options_add_declared_keys_alone(
    words: tuple[str, ...], tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capfd: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    log(tmp_path / "log.csv")
    assert main([*words, "--json"]) == 0, capfd.readouterr().err
    check_printed(words, json.loads(capfd.readouterr().out))


def test_a_key_that_is_not_declared_is_refused() -> None:
    check_printed(["show"], {"file": "recording.rrd"})
    with pytest.raises(ValidationError, match="unexpected"):
        check_printed(["show"], {"file": "recording.rrd", "more": 1})


def test_a_kind_that_is_none_is_refused_with_the_nearest(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["schema", "diagnos"]) == 2
    assert "KIND: no schema is called 'diagnos' (did you mean diagnose" in capsys.readouterr().err
