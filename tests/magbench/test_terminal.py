"""Tables and texts at 80 columns: no word is broken, and a table that does not fit is a list."""

from __future__ import annotations

import sys
from pathlib import Path
from types import SimpleNamespace

import pytest
from rich.console import Console

from magbench import console
from magbench.app import COMMANDS
from magbench.cli import main
from magbench.console import show_points, show_table, show_text
from magbench.diagnosis_tables import show_answer
from magbench.refusal import refuse

HEADS = ("calibrator", "status", "holdout_level_component_rms", "holdout_sphere_component_rms")
ROW = ("ellipsoid", "not_converged", "1234.5", "2345.6")
LOG = Path(__file__).parents[2] / "docs" / "logs" / "flight.bin"


@pytest.fixture(autouse=True)
def _narrow(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("COLUMNS", "80")


def test_a_table_that_fits_is_a_table(capsys: pytest.CaptureFixture[str]) -> None:
    show_table("calibrations", HEADS[:2], [ROW[:2]])
    assert "┃ calibrator ┃" in capsys.readouterr().out


def test_a_table_that_does_not_fit_is_a_list(capsys: pytest.CaptureFixture[str]) -> None:
    show_table("calibrations", HEADS, [ROW, ROW])
    told = capsys.readouterr().out.splitlines()
    assert told[:3] == ["calibrations", "calibrator: ellipsoid", "  status: not_converged"]
    assert all(f"  {head}: {cell}" in told for head, cell in zip(HEADS[1:], ROW[1:], strict=True))


def test_no_word_of_a_table_is_broken(capsys: pytest.CaptureFixture[str]) -> None:
    heads = ("calibrator", "level survey, nT", "all attitudes, nT", "heading, °", "status")
    show_table("", heads, [("vector_least_squares", "2362", "6926", "3.625", "unobservable")] * 2)
    assert "unobservable" in capsys.readouterr().out


def test_no_word_is_broken_that_stands_whole_in_another_cell(capsys: pytest.CaptureFixture[str]) -> None:
    heads = ("gate", "verdict", "measured", "limit", "trials", "smallest defect seen")
    rows = [
        ("ellipsoid holdout_level_component_rms", "fail", "61.8 x ellipsoid", "9 x ellipsoid", "9", "9 x ellipsoid")
    ]
    show_table("", heads, rows, numbers=False)
    assert capsys.readouterr().out.count("ellipsoid") == 4


def test_a_column_of_sentences_does_not_become_a_tower(capsys: pytest.CaptureFixture[str]) -> None:
    sentence = "the measurements are not on a sphere and this method cannot rule out soft iron " * 3
    show_table("", HEADS[:3], [["sphere", sentence, sentence]])
    assert len(capsys.readouterr().out.splitlines()) < 12


def test_lines_of_a_pipe_without_a_width_stay_whole(
    capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.delenv("COLUMNS")
    show_text("word " * 60)
    assert len(capsys.readouterr().out.splitlines()) == 1


def test_a_name_between_colons_is_no_picture(capsys: pytest.CaptureFixture[str]) -> None:
    show_text("motor_ellipsoid:battery: ok")
    assert capsys.readouterr().out.strip() == "motor_ellipsoid:battery: ok"


def test_messages_are_broken_between_words_on_a_terminal_alone(
    capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    text = " ".join(["words"] * 30)
    for terminal in (False, True):
        monkeypatch.setattr(sys.stderr, "isatty", lambda terminal=terminal: terminal)
        monkeypatch.setattr(console, "messages", Console(stderr=True, soft_wrap=True, force_terminal=terminal))
        console.say(text)
        refuse(text)
        lines = capsys.readouterr().err.splitlines()
        assert (len(lines) == 2) is not terminal
        assert set(" ".join(lines).split()) == {"magbench:", "words"}
        assert max(map(len, lines)) <= 80 or not terminal


def test_each_command_is_told_in_a_line_of_the_help(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["--help"]) == 0
    told = capsys.readouterr().out
    assert "..." not in told.split("Commands:")[1]
    for name in COMMANDS:
        assert main([name, "--help"]) == 0
        assert max(map(len, capsys.readouterr().out.splitlines())) <= 80


@pytest.mark.parametrize("others", [(), ("bandwidth",)])
def test_a_diagnosis_has_a_column_of_alternatives_where_there_are_any(
    others: tuple[str, ...], capsys: pytest.CaptureFixture[str]
) -> None:
    cause = SimpleNamespace(name="latency", alternatives=others, parameters=[("delay_s", "0.1", "0.09", "0.11", "s")])
    empty: tuple[object, ...] = ()
    show_answer(SimpleNamespace(headline="", stated=empty, diff=empty, causes=[cause], gaps=empty, parts=empty))  # type: ignore[arg-type]
    told = capsys.readouterr().out
    assert "latency" in told
    assert ("┃ or" in told) is bool(others)


def test_points_hang_below_their_text(capsys: pytest.CaptureFixture[str]) -> None:
    show_points([("!", "word " * 30)])
    first, second, *_ = capsys.readouterr().out.splitlines()
    assert (first[:6], second[:6]) == ("! word", "  word")


def test_a_matrix_keeps_its_rows(capsys: pytest.CaptureFixture[str]) -> None:
    matrix = "\n".join([" 0.94412 -0.01970  0.01451"] * 3)
    row = ["motor_ellipsoid", "unobservable", "7171 ± 3301\n-4735 ± 3157\n7784 ± 270", matrix]
    show_table("calibrations", ["calibrator", "status", "offset, nT (95\u00a0%)", "matrix"], [row])
    told = capsys.readouterr().out
    assert told.count("0.94412 -0.01970  0.01451") == 3
    assert max(map(len, told.splitlines())) <= 80


def test_inspect_answers_in_its_first_lines(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["inspect", str(LOG)]) == 0
    told = capsys.readouterr()
    lines = told.out.splitlines()
    assert lines[0] == "flight.bin: no warning, nothing to mend."
    assert "suffices for ellipsoid" in lines[1]
    assert len(lines) < 40
    assert max(map(len, lines)) <= 80
    assert all(line.startswith("inspecting flight.bin: ") for line in told.err.splitlines())  # on a busy machine


def test_inspect_in_full_lists_what_is_in_order(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["inspect", str(LOG), "--full"]) == 0
    assert "Time stamps increase strictly." in " ".join(capsys.readouterr().out.split())
