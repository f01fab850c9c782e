"""Damaged calibrations of other programs, judged by a log: an answer or one line, and no figure that is not finite."""

from __future__ import annotations

import json
from dataclasses import dataclass
from pathlib import Path

import pytest
from hypothesis import strategies as st

from recordings import write_recording
from tests.fuzz.contract import amounts, fuzz, hold
from tests.fuzz.tables import Bytes, broken_bytes
from tests.validation.rechecking.test_recheck import EXACT, STRENGTH, log
from validation.calibrating.calibration_file import write_calibrations

CASES = 12
"""Cases of each form in the normal run."""
FORMS = ("calibration.json", "mag_calibration.h", "px4.params", "ardupilot.param", "magnetometer.yaml")
NUMBERS = ("nan", "inf", "-1e999", "1e308", "0", "5e-324", "9" * 400, "", "1,2", "0x10", "٣")


@dataclass(frozen=True)
class Word:
    """A number of a text in place of another."""

    at: int
    new: str

    def to(self, content: bytes) -> bytes:
        """The changed text."""
        words = content.decode("utf-8", "replace").split(" ")
        numbers = [k for k, word in enumerate(words) if any(c.isdigit() for c in word)] or [0]
        words[numbers[self.at % len(numbers)]] = self.new
        return " ".join(words).encode()


@pytest.fixture(scope="module")
def place(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The same calibration in every form, and a log."""
    place = tmp_path_factory.mktemp("forms")
    write_calibrations({"ellipsoid": EXACT}, place, ["c", "px4", "ardupilot", "ros"])
    write_recording(log(0), place / "log.parquet")
    return place


@amounts
@pytest.mark.parametrize("form", FORMS)
def test_parameter_files(form: str, place: Path, times: int) -> None:
    whole = (place / form).read_bytes()
    old = place / f"damaged{Path(form).suffix}"

    def check(case: tuple[Bytes | Word, ...]) -> None:
        content = whole
        for one in case:
            content = one.to(content)
        old.write_bytes(content)
        strength = str(STRENGTH.strength_nT)
        hold(place / "out", "recheck", str(old), str(place / "log.parquet"), "--field-strength-nT", strength, "--json")

    words = st.builds(Word, st.integers(0, 100), st.sampled_from(NUMBERS))
    fuzz(st.lists(broken_bytes | words, min_size=1, max_size=3).map(tuple), check, CASES, times)


@pytest.mark.parametrize("form", FORMS[1:])
def test_a_number_beyond_all_fields_is_refused(form: str, place: Path) -> None:
    """In the place of each number: finite, and a product with its unit is not."""
    file, whole = place / f"large{Path(form).suffix}", (place / form).read_bytes()
    for at in range(20):
        file.write_bytes(Word(at, "1e308").to(whole))
        hold(place / "out", "recheck", str(file), str(place / "log.parquet"), "--field-strength-nT", "49000", "--json")


def test_both_arguments_may_be_anything(place: Path) -> None:
    for k, (old, new) in enumerate((("log.parquet", "log.parquet"), ("px4.params", "px4.params"))):
        assert hold(place / f"out{k}", "recheck", str(place / old), str(place / new), "--json") == 2
    assert json.loads((place / "calibration.json").read_text())
