"""A diagnosis in words and rows: what the report and the terminal share."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from validation.diagnosis.result import Diagnosis, Named, Verdict, parameters, short
from validation.text import digits
from validation.views.series import rms_nT, sides

MEANING: dict[Verdict, str] = {
    "none": "no gap beyond the noise",
    "named": "one cause, and what is left is clean",
    "class": "one cause, of several that the data do not tell apart",
    "composite": "several causes, and what is left is clean",
    "partial": "causes that explain half and more, but something is left",
    "generic": "a slow disturbance whose cause the data do not tell",
    "unknown": "no effect of the library explains the gap",
    "not_observable": "on this motion other effects look the same",
}
SEEN = {
    "held-out": "gain on held-out data",
    "direct": "seen in the values themselves",
    "base": "iron or sensor constants differ from the model's",
    "spectrum": "the spectrum of what is left",
}


def headline(found: Diagnosis) -> str:
    """Verdict, sentence and what to do next."""
    lines = [f"verdict: {found.verdict} ({MEANING[found.verdict]})", found.sentence]
    if found.advice:
        lines += ["", "what to do next", *(f"{i}. {line}" for i, line in enumerate(found.advice, start=1))]
    return "\n".join(lines)


def parameter_rows(one: Named) -> Iterator[tuple[str, str, str | None, str | None, str]]:
    """Name, value, ends of the 95 % interval (None: not known) and unit of the parameters that are in use."""
    for name, p in parameters(one).items():
        if p["low"] is not None:
            yield name, short(p["value"]), short(p["low"]), short(p["high"]), p["unit"]
        elif isinstance(p["value"], str) or np.any(p["value"]):
            yield name, short(p["value"]), None, None, p["unit"]


def gap_rows(found: Diagnosis) -> list[tuple[str, ...]]:
    """The gap as rows: what, rms before and after in nT, and in units of the noise, and the share explained."""
    gap = found.gap
    share = "no gap" if gap.explained is None else f"{100 * gap.explained:.1f} %"
    sizes = [digits(v) for v in (gap.before_nT, gap.after_nT, gap.before_sigma, gap.after_sigma)]
    rows = [("held-out segments, iron fitted anew", *sizes, share)]
    if found.problem.mode == "vector":
        both = sides(found)
        sizes = [digits(rms_nT(found, both.measured_nT - side)) for side in (both.before_nT, both.after_nT)]
        rows.append(("whole recording, models as they stand", *sizes, "", "", ""))
    return rows
