"""The mutants of a source, the tests that are chosen for a line, and what is set aside."""

from __future__ import annotations

import ast
import textwrap
import tomllib
from pathlib import Path

from benchmarks.mutants.__main__ import summary
from benchmarks.mutants.aside import REASONS, set_aside
from benchmarks.mutants.changes import mutants
from benchmarks.mutants.covering import Cover, Imports, chosen
from benchmarks.mutants.observing import Observed
from benchmarks.mutants.places import Source

ROOT = Path(__file__).resolve().parents[2]
SOURCE = textwrap.dedent(
    '''
    """A text with 3 < 4."""
    µ: float = 2.5


    def heading(x: float, y: float = 0.0) -> float:
        if not x > y or x == 3:
            raise ValueError(f"{x + 1} is odd")
        return -x * (y)
    '''
)
FIELD = textwrap.dedent(
    """
    LIMIT = 3.0

    @njit(cache=True)
    def loop(x):
        return LIMIT * x

    class Field:
        gain = 2.0

        def at(self, x, scale=1.0):
            if x > 0.0:
                return loop(
                    self.gain * x
                )
            return scale
    """
)
CHAIN = "from sim.field import loop\n\ndef apply(x):\n    return loop(x)\n"


def test_each_operator_comparison_word_sign_number_and_result_is_made_another():
    found = {(m.line, m.before, m.after) for m in mutants("a.py", SOURCE)}
    assert found == {
        (3, "2.5", "5.0"),
        (6, "0.0", "1.0"),
        (7, "not x > y", "x > y"),
        (7, ">", "<="),
        (7, "or", "and"),
        (7, "==", "!="),
        (7, "3", "4"),
        (9, "-x", "x"),
        (9, "*", "/"),
        (9, "-x * (y)", "None"),
    }
    assert {m.before for m in mutants("a.py", SOURCE)} - {m.before for m in mutants("a.py", SOURCE, numbers=False)} == {
        "2.5",
        "0.0",
        "3",
    }


def test_the_lengths_of_a_zip_are_no_mutant_but_another_strict_is() -> None:
    text = "for x in zip(a, b, strict=True):\n    read(x, strict=True)\nzip(a, b, strict=False)\n"
    assert [(m.line, m.before) for m in mutants("a.py", text)] == [(2, "True"), (3, "False")]


def test_a_mutant_changes_its_place_alone_and_can_be_read():
    for mutant in mutants("a.py", SOURCE):
        text = mutant.applied(SOURCE)
        ast.parse(text)
        assert text != SOURCE
        assert text[: mutant.start] == SOURCE[: mutant.start]
        assert text.endswith(SOURCE[mutant.end :])


def test_a_key_outlives_changes_elsewhere_in_the_file():
    product = next(m for m in mutants("a.py", SOURCE) if m.before == "*")
    later = next(m for m in mutants("a.py", f"import math\n{SOURCE}") if m.before == "*")
    assert product.key(SOURCE) == later.key(f"import math\n{SOURCE}") == "a.py: return -x [* -> /] (y)"


def test_a_place_is_its_statement_or_the_head_of_one():
    source = Source(FIELD)
    assert source.place(2).names == {"LIMIT"}
    assert source.place(6).kernel
    assert source.place(6).names == {"loop"}
    assert not source.place(9).called
    assert source.place(9).names == {"Field", "gain"}
    assert not source.place(11).called  # a default
    assert source.place(11).around == range(11, 17)
    assert source.place(12).lines == range(12, 13)
    assert source.place(14).lines == range(13, 16)
    assert not source.place(14).kernel


def field_cover() -> Cover:
    """A field with a compiled loop, a chain that calls it, and tests of each that ran some lines."""
    imports = Imports(
        {
            "sim/field.py": frozenset(),
            "sim/chain.py": frozenset({"sim/field.py"}),
            "tests/sim/test_field.py": frozenset({"sim/field.py"}),
        }
    )
    by_line = {
        "sim/field.py": {12: {"tests/sim/test_field.py::test_at"}, 13: {"tests/sim/test_field.py::test_at"}},
        "sim/chain.py": {4: {"tests/sim/test_chain.py::test_apply"}},
    }
    seconds = {"tests/sim/test_field.py::test_at": 0.5, "tests/sim/test_chain.py::test_apply": 0.1}
    return Cover({"sim/field.py": Source(FIELD), "sim/chain.py": Source(CHAIN)}, imports, Observed(seconds, by_line))


def test_a_line_has_the_tests_that_run_it_and_a_compiled_one_those_of_its_callers():
    cover, at, apply = field_cover(), "tests/sim/test_field.py::test_at", "tests/sim/test_chain.py::test_apply"
    assert cover.tests("sim/field.py", 12) == {at}
    assert cover.tests("sim/chain.py", 4) == {apply}
    assert cover.tests("sim/field.py", 6) == {at, apply}
    assert cover.tests("sim/field.py", 2) == {at, apply}  # a constant of the compiled loop
    assert cover.tests("sim/field.py", 16) == {at}  # run by none: those of its file


def test_a_mistake_outside_the_loops_is_compiled_into_none_but_its_own_files():
    cover = field_cover()
    assert cover.imports.users("sim/field.py")["tests/sim/test_field.py"] == 1
    assert cover.kernels("sim/field.py", 2) == ["sim/field.py"]
    assert cover.kernels("sim/chain.py", 4) == []


def test_the_mirror_comes_first_then_the_fastest_within_the_time():
    seconds = {
        "tests/sim/test_field.py::test_slow": 3.0,
        "tests/sim/test_field.py::test_prepared": 1.0,
        "tests/sim/test_chain.py::test_slow": 2.0,
        "tests/sim/test_chain.py::test_fast": 0.1,
        "tests/sim/test_engine.py::test_fast": 0.2,
        "tests/sim/test_other.py::test_fast": 0.1,
    }
    given = [test for test in seconds if "prepared" not in test and "other" not in test]
    assert list(chosen("sim/field.py", given, seconds, most_s=5.0)) == [
        "tests/sim/test_field.py::test_slow",
        "tests/sim/test_field.py::test_prepared",
        "tests/sim/test_chain.py::test_fast",
        "tests/sim/test_engine.py::test_fast",
    ]
    assert list(chosen("sim/field.py", given[:1], seconds, most_s=0.0)) == ["tests/sim/test_field.py::test_slow"]


def test_survivors_that_are_set_aside_do_not_count():
    key, word = next(iter(set_aside().items()))
    rows = [
        {"key": "a", "verdict": "killed"},
        {"key": "b", "verdict": "survived"},
        {"key": "c", "verdict": "timed out"},
    ]
    assert summary([*rows, {"key": key, "verdict": "survived"}]) == (
        f"killed 2 of 3 (1 of them timed out), 1 set aside (1 {word})"
    )


def test_what_is_set_aside_names_a_file_and_a_reason():
    reasons = tomllib.loads(REASONS.read_text(encoding="utf-8"))
    assert all((ROOT / key.split(": ")[0]).is_file() for key in set_aside())
    assert all(reason for keys in reasons.values() for reason in keys.values())
