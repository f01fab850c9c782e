"""Names of gates go into XML, Markdown and annotations: what cannot be printed is refused."""

from __future__ import annotations

import pytest
from pydantic import ValidationError

from validation.gates.gate_file import Gate


def named(name: str) -> Gate:
    given = {"name": name, "scenario": "s", "calibrator": "sphere", "score": "offset_error_nT", "limit": 1.0}
    return Gate.model_validate(given)


@pytest.mark.parametrize("name", ["a\x01b", "a\x1b[2Jb", "a\x7fb", "a\ufffeb", "a\u202eb", "a\tb"])
def test_a_name_that_cannot_be_printed_is_refused(name: str) -> None:
    with pytest.raises(ValidationError, match="cannot be printed"):
        named(name)


def test_other_alphabets_are_names() -> None:
    assert named("Ölmessung 磁力 <&>").name == "Ölmessung 磁力 <&>"
