"""A diagnosis on disk: diagnosis.json, model.toml and report.html."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import jinja2

from scenarios.toml import to_toml
from sim.dataset.files import alone_in, write_text
from validation.diagnosis.result import Diagnosis, Named, parameters, short
from validation.plots import diagnosis as plots
from validation.plots.style import encoded
from validation.wording import digits

PICTURES = (
    ("What each candidate explains", "Each effect alone, beside hard and soft iron fitted anew.", plots.draw_ranking),
    ("The gap over time", "Body axes; hard and soft iron refitted. Blue should be noise.", plots.draw_gap),
    ("The gap by frequency", "A clean rest lies on the dashed line.", plots.draw_spectrum),
    ("The gap by channel", "Against the channels it goes with most: a clue, not a proof.", plots.draw_channel),
)


def write_diagnosis(found: Diagnosis, out: Path, title: str) -> None:
    """Write the three files into a directory, each whole or not at all; InputError where that is refused."""
    with alone_in(out):
        write_text(out / "model.toml", to_toml(found.model))
        write_text(
            out / "diagnosis.json",
            json.dumps(found.as_dict() | {"model_out": "model.toml"}, indent=1, default=str) + "\n",
        )
        loader = jinja2.PackageLoader("validation", "templates")
        environment = jinja2.Environment(loader=loader, autoescape=True, undefined=jinja2.StrictUndefined)
        write_text(out / "report.html", environment.get_template("diagnosis.html").render(_page(found, title)))


def _page(found: Diagnosis, title: str) -> dict[str, Any]:
    gap = found.gap
    explained = gap.explained
    return {
        "title": title,
        "verdict": found.verdict,
        "sentence": found.sentence,
        "effects": [_row(one) for one in found.named],
        "gap": [digits(v) for v in (gap.before_nT, gap.after_nT, gap.before_sigma, gap.after_sigma)],
        "explained": "There is no gap beyond the noise."
        if explained is None
        else f"{100 * explained:.1f} % explained.",
        "left": "; ".join(found.after.why),
        "advice": found.advice,
        "where": found.where,
        "model": to_toml(found.model),
        "pictures": [
            {"title": name, "caption": caption, "data": encoded(lambda draw=draw: draw(found))}  # type: ignore[misc]
            for name, caption, draw in PICTURES
        ],
    }


def _share(explained: float | None) -> str:
    return "There is no gap beyond the noise." if explained is None else f"{100 * explained:.1f} % of it explained."


def _row(one: Named) -> dict[str, Any]:
    lines = []
    for name, p in parameters(one).items():
        if p["low"] is not None:
            lines.append(f"{name} = {short(p['value'])} [{short(p['low'])} to {short(p['high'])}] {p['unit']}")
        elif p["value"] not in (0, 0.0):
            lines.append(f"{name} = {short(p['value'])} {p['unit']}")
    strength = f"{one.strength:.2g} sigma, {one.D:.3g} nats" if one.how in ("held-out", "base") and one.D else ""
    return {"name": one.name, "alternatives": one.alternatives, "lines": lines, "how": one.how,
            "evidence": ", ".join(filter(None, (strength, one.evidence)))}  # fmt: skip
