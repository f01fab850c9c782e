"""What of their noise several recordings bear out."""

from __future__ import annotations

from dataclasses import dataclass
from types import SimpleNamespace
from typing import Any

import pytest

from validation.together.judgement import _borne_out

TOLD, OPEN = SimpleNamespace(identified=True), SimpleNamespace(identified=False)


@dataclass(frozen=True)
class Leaves:
    """Of a belief whether what is left is white, and the noise that it is."""

    white: bool
    noise: Any = None

    @property
    def after(self) -> Any:
        return SimpleNamespace(clean=self.white)


@pytest.mark.parametrize(
    ("noise", "third", "stays"),
    [(OPEN, Leaves(True), False), (OPEN, Leaves(False), True), (TOLD, Leaves(True), True)],
)
def test_noise_of_open_nature_is_none_where_another_recording_is_white(noise: Any, third: Leaves, stays: bool) -> None:
    found = _borne_out([Leaves(False, noise), Leaves(False, noise), third])  # type: ignore[list-item]
    assert [one.noise for one in found] == ([noise, noise, None] if stays else [None] * 3)
