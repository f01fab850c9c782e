"""The tables of docs that come from the code, written between marks in the pages: effects, calibrators, keys, units.

A page holds `<!-- table: NAME -->` and `<!-- end -->`; what stands between them is made here. `tests/test_readme.py`
checks that the pages are what the code says, all but MEASURED, which are measurements.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Iterable
from pathlib import Path
from typing import Annotated, Any, Literal, get_args, get_origin

import numpy as np
from pydantic import BaseModel
from pydantic.fields import FieldInfo
from scipy.spatial.transform import Rotation

from calib import CALIBRATORS, Calibrator
from scenarios.load import catalogue
from scenarios.paths import PHASES, Ability
from scenarios.spec import FieldSpec, NavigationSpec, SamplingSpec, ThermalSpec
from scenarios.varied import Vary
from sim.dataset.units import UNITS
from sim.effects import EFFECTS
from sim.effects.base import Effect
from sim.effects.values import Parameter
from sim.motion import Motion, drive
from sim.scenario import Scenario, SensorSpec, load
from sim.sensors import SENSORS, Figure, Sensor
from sim.streams import stream
from sim.vehicles import VEHICLES, able
from validation.diagnosis.verdict import Verdict
from validation.scoring.meaning import MEANINGS
from validation.signals.conventions import euler_deg
from validation.text import symbol

DOCS = Path(__file__).parent
README = DOCS.parent / "README.md"
COUNTS = {"effects": len(EFFECTS), "(?:calibrators|methods)": len(CALIBRATORS)}
"""What README counts."""
MARKS = re.compile(r"(<!-- table: ([\w-]+) -->\n)(.*?)(<!-- end -->)", re.DOTALL)
WORD = re.compile(r"-?\w+(?:\.\w+)*")
STAGES = ("field", "vehicle", "sensor", "electronics")
SHOWN_HZ = 10.0
"""Sample rate at which the noise of a density is shown."""
KEY_HEADS = ("key", "value", "default", "range", "meaning")
TRACKED = (
    *("auv-spiral", "auv-spiral-excited", "auv-comb"),
    *("quad-spiral", "quad-comb", "quad-calibration"),
    *("turntable-twelve-stops", "turntable-three-turns", "tumble"),
)
TYPES = {
    "Effects": "tables",
    "float": "number",
    "int": "whole number",
    "str": "text",
    "date": "date",
    "bool": "true or false",
}


def fill(page: str, *, measured: bool = True) -> str:
    """The text of a page with its tables made anew; measured=False leaves tables of measurements as they are."""

    def made(found: re.Match[str]) -> str:
        keep = found[2] in MEASURED and not measured
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
    if p.options:
        return f"`{p.name}`: {p.doc}"
    return f"`{p.name}`: {p.doc}" + (f" [{p.unit}]" if p.unit else "")


def static() -> str:
    """The effects that a calibration of the instrument can take out, and that the hold-out keeps."""
    return ", ".join(f"`{cls.name}`" for cls in EFFECTS if cls.static) + "\n"


# scores


def scores() -> str:
    """Every score: its name, its title in tables, its unit and what it means."""
    rows = ((f"`{one.name}`", one.short, symbol(one.unit), one.explained) for one in MEANINGS.values())
    return _table(("score", "in tables", "unit", "what it is"), rows)


# calibrators

NEED_TEXT = {
    "attitude": "attitude",
    "gyro": "gyro",
    "accel": "accelerometer",
    "scalar": "channel `scalar_nT`",
    "array": "array of sensors",
    "field_vector": "field vector",
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


# scenario files


def scenarios() -> str:
    """The catalogue."""
    known = {name: load(name) for name in catalogue()}
    rows = ((f"`{name}`", scenario.vehicle.kind, scenario.summary) for name, scenario in known.items())
    return _table(("scenario", "vehicle", "what it is"), rows)


def keys(*models: type[BaseModel]) -> Callable[[], str]:
    """Table of the keys of one or more tables of a scenario file."""
    return lambda: _table(KEY_HEADS, (row for m in models for row in _keys(m)))


def vehicles() -> str:
    """Every kind of vehicle with its keys."""
    parts = []
    for kind, cls in VEHICLES.items():
        rows = list(_keys(cls.table))
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
        who = ", ".join(able(model))
        head = f'**`kind = "{kind}"`** ({who}). {_summary(model)}'
        parts.append(head + "\n\n" + _table(KEY_HEADS, _keys(model)))
    return "\n".join(parts)


def sheets() -> str:
    """Every sensor with the figures of its data sheet and the effects that stand for them."""
    return "\n".join(map(_sheet, SENSORS.values()))


def _sheet(sensor: Sensor) -> str:
    rate = f" At most {sensor.fastest_hz:g} samples a second." if sensor.fastest_hz else ""
    head = f"**`{sensor.name}`**. {sensor.summary}.{rate} Source: {sensor.document}. Left out: {sensor.left_out}."
    rows = ((one.quantity, one.words + ("" if one.compared else " †"), _stands(one)) for one in sensor.figures)
    return head + "\n\n" + _table(("quantity", "data sheet", "effect"), rows)


def _stands(figure: Figure) -> str:
    """The effect of a figure, with the parameters that are drawn by their law."""
    laws = {key: next(iter(how.model_dump(exclude_none=True).items())) for key, how in figure.spread.items()}
    drawn = [f"`{key}` {name} {_pair(pair)}" for key, (name, pair) in laws.items()]
    fixed = [f"`{key}` {_pair(value)}" for key, value in figure.at(SHOWN_HZ).items() if key not in laws]
    return f"`{figure.effect.name}`: " + ", ".join((*drawn, *fixed))


def _pair(value: Any) -> str:
    numbers = np.atleast_1d(value)
    same = len(numbers) == 3 and len(set(numbers)) == 1
    return ", ".join(f"{number:.6g}" for number in (numbers[:1] if same else numbers))


def variations() -> str:
    """Every distribution of `[vary]`, and what bounds or mirrors it."""
    return _table(("key", "value"), ((f"`{name}`", _meaning(info)) for name, info in Vary.model_fields.items()))


def _summary(model: type[BaseModel]) -> str:
    return " ".join((model.__doc__ or "").split("\n\n")[0].split())


def _keys(model: type[BaseModel]) -> Iterable[tuple[str, ...]]:
    for name, info in model.model_fields.items():
        if name not in ("kind", "name", "summary", "field", "vehicle", "phases"):
            yield (f"`{info.alias or name}`", _kind(info.annotation), _default(info), _range(info), _meaning(info))


def _kind(annotation: Any) -> str:
    if get_origin(annotation) is Annotated:
        return _kind(get_args(annotation)[0])
    if get_origin(annotation) is Literal:
        return ", ".join(f'"{word}"' for word in get_args(annotation))
    parts = [part for part in get_args(annotation) if part is not type(None)]
    if get_origin(annotation) is tuple:
        return {"number": f"{len(parts)} numbers", "text": "list of names"}.get(_kind(parts[0]), "array of tables")
    if get_origin(annotation) is dict:
        return "tables"
    if parts:
        return _kind(parts[0])
    return TYPES.get(annotation.__name__, "table")


def _default(info: FieldInfo) -> str:
    if info.is_required():
        return "required"
    value = info.default
    if value is None or not isinstance(value, int | float | str | tuple) or isinstance(value, BaseModel):
        return "–"
    if isinstance(value, tuple):
        return ", ".join(f"{v:g}" if isinstance(v, float) else str(v) for v in value if isinstance(v, float | str))
    return f"{value:.7g}" if isinstance(value, float) else str(value)


def _range(info: FieldInfo) -> str:
    signs = {"ge": "≥", "gt": ">", "le": "≤", "lt": "<"}
    found = [
        f"{sign} {getattr(rule, key):g}" for rule in info.metadata for key, sign in signs.items() if hasattr(rule, key)
    ]
    return ", ".join(found) or "–"


def _meaning(info: FieldInfo) -> str:
    return info.description or ""


# tracking


def tracking(names: Iterable[str] = TRACKED) -> str:
    """How far each vehicle is from its reference, after the run-in of each phase (`settle_s`)."""
    rows = (row for name in names for row in _tracked(load(name)))
    return _table(("scenario", "phase", "position, rms", "largest", "attitude, rms", "pitch", "roll"), rows)


def _tracked(scenario: Scenario) -> Iterable[tuple[str, ...]]:
    parts: dict[int, list[Motion]] = {}
    for motion in drive(scenario, stream(scenario.seed, 0, "flow")):
        parts.setdefault(motion.phase, []).append(motion)
    for index, motions in parts.items():
        settled = np.concatenate([m.phase_time_s for m in motions]) > scenario.phases[index].settle_s
        phase, tilts = scenario.phases[index], Ability.SWAY not in VEHICLES[scenario.vehicle.kind].abilities
        figures = np.concatenate([_errors(tilts, m) for m in motions])[settled]
        yield (f"`{scenario.name}`", phase.kind, *_cells(phase.tracked, figures))


def _errors(tilts: bool, motion: Motion) -> Any:
    """Rows (n, 4): distance from the reference in m, angle from it in degrees, pitch and roll in degrees."""
    apart_m = np.linalg.norm(motion.reference[:, :3] - motion.kinematics.pos_enu_m, axis=1)
    wanted = Rotation.from_euler("ZYX", motion.reference[:, 9:12])
    apart_deg = np.degrees((wanted.inv() * Rotation.from_matrix(motion.R_wb)).magnitude())
    yaw_deg, pitch_deg, roll_deg = euler_deg(motion.kinematics.q).T
    if not tilts:  # its tilt follows from its acceleration: only the heading is commanded
        apart_deg = (yaw_deg - np.degrees(motion.reference[:, 9]) + 180.0) % 360.0 - 180.0
    return np.column_stack([apart_m, apart_deg, pitch_deg, roll_deg])


def _cells(tracked: bool, figures: Any) -> tuple[str, ...]:
    rms = np.sqrt(np.mean(figures[:, :2] ** 2, axis=0))
    distance = (_length(rms[0]), _length(figures[:, 0].max())) if tracked else ("–", "–")
    low, high = np.round(figures[:, 2:], 1).min(axis=0) + 0.0, np.round(figures[:, 2:], 1).max(axis=0) + 0.0
    turns = (f"{a:.1f} to {b:.1f}°" for a, b in zip(low, high, strict=True))
    return (*distance, "< 0.001°" if rms[1] < 1e-3 else f"{rms[1]:.2g}°", *turns)


def _length(metres: float) -> str:
    return f"{1e3 * metres:.2g} mm" if metres < 0.0995 else f"{metres:.2g} m"


# papers


def ellipsoid() -> str:
    """The ellipsoid's fit of [Zhang2018]'s circles under a drifting hard iron."""
    import reproduced  # beside this file; it simulates and fits for half a minute

    heads = ("drift, nT/h", "whole record, rms nT", "segments found", "a segment a turn")
    return _table(heads, reproduced.ellipsoid())


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
    **{f"verdict-{name}": verdict(name) for name in Verdict},
}
"""Every table by the name that a page asks for."""
MEASURED = ("tracking", "zhang2018-ellipsoid", *(name for name in TABLES if name.startswith("verdict-")))


if __name__ == "__main__":
    write_all()
