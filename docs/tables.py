"""The tables of docs that come from the code, written between marks in the pages: effects, calibrators, keys, units.

A page holds `<!-- table: NAME -->` and `<!-- end -->`; what stands between them is made here. `tests/test_readme.py`
checks that the pages are what the code says, all but MEASURED, which are measurements.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Iterable
from pathlib import Path

import peers as public
import schema_keys
import sensor_sheets
import tracked
from pydantic import BaseModel

from calib import CALIBRATORS, Calibrator
from diagnosis.verdict import Verdict
from recordings.readers import FORMATS, FileFormat
from recordings.units import UNITS
from scenarios.load import catalogue
from scenarios.paths import PHASES
from scenarios.spec import FieldSpec, NavigationSpec, SamplingSpec, ThermalSpec
from scenarios.varied import Vary
from sim.effects import EFFECTS
from sim.effects.base import Effect
from sim.effects.parameters import Parameter
from sim.scenario import SensorSpec, load
from sim.vehicles import VEHICLES, vehicles_for
from validation.scoring.definitions import SCORE_DEFINITIONS
from validation.text import symbol

DOCS = Path(__file__).parent
README = DOCS.parent / "README.md"
COUNTS = {"effects": len(EFFECTS), "(?:calibrators|methods)": len(CALIBRATORS)}
"""What README counts."""
MARKS = re.compile(r"(<!-- table: ([\w-]+) -->\n)(.*?)(<!-- end -->)", re.DOTALL)
WORD = re.compile(r"-?\w+(?:\.\w+)*")
STAGES = ("field", "vehicle", "sensor", "electronics")
PEERS = "peers"
KEY_HEADS = ("key", "value", "default", "range", "meaning")


def fill(page: str, *, measured: bool = True) -> str:
    """The text of a page with its tables made anew; measured=False leaves tables of measurements as they are.

    The public packages' is left too where no environment of theirs is named.
    """

    def made(found: re.Match[str]) -> str:
        keep = found[2] in MEASURED and (not measured or (found[2] == PEERS and not public.asked()))
        return found[1] + (found[3] if keep else TABLES[found[2]]()) + found[4]

    return MARKS.sub(made, page)


def counted(page: str) -> str:
    """The text of a page with its numbers of effects and calibrators made anew."""
    for words, count in COUNTS.items():
        page = re.sub(rf"\b\d+(?= {words}\b)", str(count), page)
    return page


def write_all() -> None:
    """Fill every page of docs, and the counts of README."""
    for page in sorted(DOCS.glob("*.md")):
        page.write_text(fill(page.read_text(encoding="utf-8")), encoding="utf-8")
    README.write_text(counted(README.read_text(encoding="utf-8")), encoding="utf-8")


def stale(page: str, made: str) -> list[str]:
    """Lines of a page that the page as made today does not hold; a list of names in a line may have grown."""
    lines = made.splitlines()
    known, grown = set(lines), [WORD.findall(line) for line in lines if line not in page]
    return [line for line in page.splitlines() if line not in known and not any(_within(line, one) for one in grown)]


def _within(line: str, words: list[str]) -> bool:
    """Whether the words of a line come in this order among others."""
    rest = iter(words)
    return all(part in rest for part in WORD.findall(line))


# effects


def effects() -> str:
    """Every effect by stage: what it adds, and its parameters."""
    parts = [_stage(stage, [cls for cls in EFFECTS if cls.stage == stage]) for stage in STAGES]
    return "\n".join(parts)


def _stage(stage: str, classes: list[type[Effect]]) -> str:
    rows = ((f"`{cls.name}`", _equations(cls), "<br>".join(map(_parameter, cls.parameters()))) for cls in classes)
    return f"### {stage.capitalize()}\n\n" + _table(("effect", "what it adds", "parameters"), rows)


def _equations(cls: type[Effect]) -> str:
    """The first paragraph of the documentation, and the others that hold an equation."""
    first, *others = re.split(r"\n\s*\n", cls.__doc__ or "")
    text = " ".join([first, *(part for part in others if "``" in part)])
    return " ".join(text.replace("``", "`").split())


def _parameter(p: Parameter) -> str:
    return f"`{p.name}`: {p.doc}" + (f" [{p.unit}]" if p.unit else "")


def static() -> str:
    """The effects that a calibration of the instrument can take out, and that the hold-out keeps."""
    return ", ".join(f"`{cls.name}`" for cls in EFFECTS if cls.static) + "\n"


# scores


def scores() -> str:
    """Every score: its name, its title in tables, its unit and what it means."""
    rows = ((f"`{one.name}`", one.short, symbol(one.unit), one.explained) for one in SCORE_DEFINITIONS.values())
    return _table(("score", "in tables", "unit", "what it is"), rows)


# calibrators

NEED_TEXT = {
    "attitude": "attitude",
    "gyro": "gyro",
    "accel": "accelerometer",
    "scalar": "channel `scalar_nT`",
    "array": "array of sensors",
    "field_vector": "field vector",
    "input": "current, throttle, motor output or temperature",
}


def calibrators() -> str:
    """Every calibrator: what it is, what it needs beside the field's strength, and the fewest samples."""
    rows = ((f"`{name}`", cls.summary, _needs(cls), str(cls.min_samples)) for name, cls in CALIBRATORS.items())
    return _table(("name", "method", "needs", "least samples"), rows)


def _needs(cls: type[Calibrator]) -> str:
    return ", ".join(NEED_TEXT[need] for need in cls.needs) or "–"


# measured logs


def units() -> str:
    """Units that `--map` understands."""
    return _table(("columns", "units"), ((kind, ", ".join(f"`{u}`" for u in table)) for kind, table in UNITS.items()))


def formats() -> str:
    """Every file format that is read: its files, the extra to install, what is undone."""
    heads = ("format", "files", "extra", "what is undone or special")
    return _table(
        heads, ((one.name, _files(one), f"`{one.extra}`" if one.extra else "–", one.remark) for one in FORMATS)
    )


def _files(one: FileFormat) -> str:
    return ", ".join(f"`{suffix}`" for suffix in one.suffixes)


# scenario files


def scenarios() -> str:
    """The catalogue."""
    known = {name: load(name) for name in catalogue()}
    rows = ((f"`{name}`", scenario.vehicle.kind, scenario.summary) for name, scenario in known.items())
    return _table(("scenario", "vehicle", "what it is"), rows)


def keys(*models: type[BaseModel]) -> Callable[[], str]:
    """Table of the keys of one or more tables of a scenario file."""
    return lambda: _table(KEY_HEADS, (row for m in models for row in schema_keys.rows(m)))


def vehicles() -> str:
    """Every kind of vehicle with its keys."""
    parts = []
    for kind, cls in VEHICLES.items():
        rows = list(schema_keys.rows(cls.table))
        head = f'**`kind = "{kind}"`**. {_summary(cls.table)}'
        parts.append(head + ("\n\n" + _table(KEY_HEADS, rows) if rows else " No other keys.\n"))
    return "\n".join(parts)


def fleet() -> str:
    """Every vehicle: what it is, how many motors draw current, and the phases that it can do."""
    rows = (
        (f"`{name}`", cls.summary, str(cls.motors), ", ".join(kind for kind, phase in PHASES.items() if cls.can(phase)))
        for name, cls in VEHICLES.items()
    )
    return _table(("name", "what it is", "motor currents", "phases"), rows)


def phases() -> str:
    """Every kind of phase with its keys."""
    parts = []
    for kind, model in PHASES.items():
        who = ", ".join(vehicles_for(model))
        head = f'**`kind = "{kind}"`** ({who}). {_summary(model)}'
        parts.append(head + "\n\n" + _table(KEY_HEADS, schema_keys.rows(model)))
    return "\n".join(parts)


def sheets() -> str:
    """Every sensor with the figures of its data sheet and the effects that stand for them."""
    return "\n".join(f"{one.head}\n\n{_table(sensor_sheets.HEADS, one.rows)}" for one in sensor_sheets.all_of_them())


def variations() -> str:
    """Every distribution of `[vary]`, and what bounds or mirrors it."""
    return _table(
        ("key", "value"), ((f"`{name}`", schema_keys.meaning(info)) for name, info in Vary.model_fields.items())
    )


def _summary(model: type[BaseModel]) -> str:
    return " ".join((model.__doc__ or "").split("\n\n")[0].split())


# measured


def tracking(names: Iterable[str] = tracked.SCENARIOS) -> str:
    """How far each vehicle is from its reference, after the run-in of each phase (`settle_s`)."""
    return _table(
        ("scenario", "phase", "position, rms", "largest", "attitude, rms", "pitch", "roll"), tracked.rows(names)
    )


def ellipsoid() -> str:
    """The ellipsoid's fit of [Zhang2018]'s circles under a drifting hard iron."""
    import reproduced  # beside this file; it simulates and fits for half a minute

    heads = ("drift, nT/h", "whole record, rms nT", "segments found", "a segment a turn")
    return _table(heads, reproduced.ellipsoid())


def flown() -> str:
    """Figures of three papers by motions flown in the engine."""
    import reproduced  # beside this file; it flies and fits for half a minute

    heads = ("figure, median", "printed", "the paper's motion", "turntable", "AUV", "quadrotor")
    return _table(heads, reproduced.flown())


def rivals() -> str:
    """The rivals that [Li2017] cites."""
    import reproduced  # beside this file

    heads = ("rival, error in nT", "strength", "worst component", "strength with eddy currents")
    return _table(heads, reproduced.rivals())


def arrangements() -> str:
    """The arrangements of sensors that [Ding2021] names."""
    import reproduced  # beside this file

    heads = ("arrangement", "error, one baseline, %", "error, in one ball, %", "noise, s / d")
    return _table(heads, reproduced.arrangements())


def peers() -> str:
    """The public packages beside our calibrators."""
    return _table(public.heads(), public.compared())


# verdicts


def verdict(name: str) -> Callable[[], str]:
    """What `magbench diagnose` says in a section of the page of verdicts."""

    def said() -> str:
        import verdicts  # beside this file; it runs the simulator

        return str(verdicts.said(name))

    return said


def _table(heads: tuple[str, ...], rows: Iterable[tuple[str, ...]]) -> str:
    lines = [heads, ("---",) * len(heads), *rows]
    return "".join("| " + " | ".join(cell.replace("|", "\\|") for cell in line) + " |\n" for line in lines)


TABLES: dict[str, Callable[[], str]] = {
    "effects": effects,
    "static": static,
    "scores": scores,
    "calibrators": calibrators,
    "units": units,
    "formats": formats,
    "catalogue": scenarios,
    "phases": phases,
    "field": keys(FieldSpec),
    "vehicles": vehicles,
    "fleet": fleet,
    "sampling": keys(SamplingSpec),
    "thermal": keys(ThermalSpec),
    "navigation": keys(NavigationSpec),
    "sensors": keys(SensorSpec),
    "vary": variations,
    "sheets": sheets,
    "tracking": tracking,
    "zhang2018-ellipsoid": ellipsoid,
    "papers-flown": flown,
    "li2017-rivals": rivals,
    "ding2021-arrangements": arrangements,
    PEERS: peers,
    **{f"verdict-{name}": verdict(name) for name in Verdict},
}
"""Every table by the name that a page asks for."""
PAPERS_TABLES = ("zhang2018-ellipsoid", "papers-flown", "li2017-rivals", "ding2021-arrangements")
MEASURED = ("tracking", *PAPERS_TABLES, PEERS, *(name for name in TABLES if name.startswith("verdict-")))


if __name__ == "__main__":
    write_all()
