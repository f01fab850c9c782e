"""The mutants of a source, and the tests that are chosen for a file."""

from __future__ import annotations

import ast
import textwrap

from benchmarks.mutants.changes import mutants
from benchmarks.mutants.covering import Imports, covering

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


def test_a_mutant_changes_its_place_alone_and_can_be_read():
    for mutant in mutants("a.py", SOURCE):
        text = mutant.applied(SOURCE)
        ast.parse(text)
        assert text != SOURCE
        assert text[: mutant.start] == SOURCE[: mutant.start]
        assert text.endswith(SOURCE[mutant.end :])


def test_the_mirror_comes_first_then_who_imports_it_then_the_neighbour():
    imports = Imports(
        {
            "sim/field.py": frozenset(),
            "sim/chain.py": frozenset({"sim/field.py"}),
            "calib/twostep.py": frozenset(),
            "tests/sim/test_field.py": frozenset(),
            "tests/sim/effects/test_earth.py": frozenset({"sim/chain.py"}),
            "tests/sim/test_engine.py": frozenset(),
            "tests/sim/conftest.py": frozenset({"sim/field.py"}),
            "tests/calib/test_twostep.py": frozenset({"calib/twostep.py", "sim/field.py"}),
        }
    )
    assert imports.users("sim/field.py")["tests/sim/effects/test_earth.py"] == 2
    assert covering("sim/field.py", imports, 3) == [
        "tests/sim/test_field.py",
        "tests/sim/effects/test_earth.py",
        "tests/sim/test_engine.py",
    ]
