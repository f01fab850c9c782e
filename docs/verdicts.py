"""The diagnoses of `verdicts.md`: its own commands run, their outcome as text and as pictures.

`make pictures` writes both anew; `tests/test_verdicts.py` checks that every section earns the verdict in its heading.
"""

from __future__ import annotations

import contextlib
import io
import re
import shlex
import tempfile
import textwrap
from collections.abc import Callable, Iterator
from functools import cache
from pathlib import Path
from typing import Any

import shown
from matplotlib.figure import Figure

from diagnosis.question import Question, answer, file_sources
from diagnosis.result import Diagnosis
from magbench.cli import main
from reports.plots.diagnosis import draw_channel, draw_gap, draw_ranking, draw_spectrum
from reports.presentation.diagnosis import PresentedDiagnosis

PAGE = Path(__file__).parent / "verdicts.md"
WIDTH, MOST_DIFF_LINES = 100, 20
PICTURES: dict[str, Callable[[PresentedDiagnosis], Figure]] = {
    "none": draw_gap,
    "named": draw_channel,
    "class": draw_ranking,
    "composite": draw_gap,
    "partial": draw_gap,
    "generic": draw_spectrum,
    "unknown": draw_channel,
    "not_observable": draw_gap,
}


def sections() -> dict[str, str]:
    """Text of each section of the page by the verdict in its heading."""
    parts = re.split(r"^## `(\w+)`$", PAGE.read_text(encoding="utf-8"), flags=re.MULTILINE)
    return dict(zip(parts[1::2], parts[2::2], strict=True))


@cache
def diagnosed() -> dict[str, PresentedDiagnosis]:
    """What each section's commands find."""
    with tempfile.TemporaryDirectory() as folder, contextlib.chdir(folder):
        text = PAGE.read_text(encoding="utf-8")
        for name, content in re.findall(r"^```toml\n# (\S+)\n(.*?)^```$", text, re.MULTILINE | re.DOTALL):
            Path(name).write_text(content, encoding="utf-8")
        return {verdict: _found(section) for verdict, section in sections().items()}


def _found(section: str) -> PresentedDiagnosis:
    (simulate,) = _commands(section, "simulate")
    ((measured, option, model, *_),) = _commands(section, "diagnose")
    assert option == "--model", section
    with contextlib.redirect_stdout(io.StringIO()), contextlib.redirect_stderr(io.StringIO()) as complaints:
        status = main(["simulate", *simulate, "--jobs", "1"])
    assert status == 0, complaints.getvalue()
    found = answer(Question.about(model), file_sources([Path(measured)], 0))
    assert isinstance(found, Diagnosis)
    return PresentedDiagnosis.of(found)


def _commands(section: str, name: str) -> Iterator[list[str]]:
    for line in section.replace("\\\n", " ").splitlines():
        if found := re.match(rf"(?:\$ )?magbench {name} (.*)", line):
            yield shlex.split(found[1])


def kept() -> dict[str, dict[str, Any]]:
    """What each verdict's text and picture show, for `generated.json`."""
    return {
        verdict: {"says": [found.verdict, shown.without_numbers(found.sentence)]}
        | shown.shown(PICTURES[verdict], found)
        for verdict, found in diagnosed().items()
    }


def said(verdict: str) -> str:
    """What the command says first, and a short change of the model, as a block of the page.

    Raises ValueError where the section's commands give another verdict.
    """
    found = diagnosed()[verdict]
    if found.verdict != verdict:
        raise ValueError(f"{PAGE.name}: the commands of section {verdict} give {found.verdict}: {found.sentence}")
    lines = [part for line in found.headline.splitlines() for part in textwrap.wrap(line, WIDTH) or [""]]
    if 0 < len(found.diff) <= MOST_DIFF_LINES:
        lines += ["", *found.diff]
    return "\n".join(["```text", *lines, "```", ""])
