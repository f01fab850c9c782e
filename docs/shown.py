"""What the pictures show, as numbers: made with them by `make pictures`, made again by the test run, and compared.

A picture's bytes tell nothing, since the same numbers are drawn in other bytes on another machine. Kept in
`generated.json` is, for each figure of a report, how many values each of its parts holds, their mean and their rms,
drawn from its scenario cut short, which takes a second where the whole takes minutes: a program that computes or draws
something else shows there too. The verdicts' figures are kept whole, and checked whole by the slow tests.

An effect, a calibrator or a vehicle that was added since changes none of this, but for the verdicts: the diagnosis
chooses among more. Those wait for `make pictures`.
"""

from __future__ import annotations

import json
import math
import re
import tempfile
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Generic, TypeVar

import matplotlib
import numpy as np
import reproduced
from matplotlib.figure import Figure as MplFigure
from matplotlib.patches import Rectangle

from calib import CALIBRATORS
from recordings import read_run
from reports.outputs.run import calibrate_and_score
from reports.plots.effects import draw_effect_sizes, draw_effects
from reports.plots.field import draw_norm, draw_residuals, draw_sphere
from reports.plots.inspection import draw_coverage
from reports.plots.motion import draw_path, draw_vehicle
from reports.plots.style import STYLE
from sim.dataset_writer import generate
from sim.effects import EFFECTS
from sim.scenario import Scenario, load
from sim.vehicles import VEHICLES
from validation.inspection.inspection import inspect_file
from validation.scoring.outcome import Outcome

FILE = Path(__file__).parent / "generated.json"
TOLERANCE = 0.01
"""Relative; what is drawn of a search's end differs more from processor to processor than the recording does."""
Shown = Mapping[str, Any]
Given = TypeVar("Given")


def draw_first_look(place: Path) -> MplFigure:
    """The directions that the first sensor of a directory's recording has seen."""
    return draw_coverage(inspect_file(place).sensors[0])


@dataclass(frozen=True)
class Figure(Generic[Given]):
    """A figure of a scenario's outcome, or of the directory of its recording."""

    file: str
    scenario: str
    draw: Callable[[Given], MplFigure]


FIGURES = (
    Figure("path-spiral.png", "auv-spiral-excited", draw_path),
    Figure("path-comb.png", "quad-comb", draw_path),
    Figure("sphere.png", "tumble", draw_sphere),
    Figure("residuals.png", "auv-dive", draw_residuals),
    Figure("strength.png", "quad-comb", draw_norm),
    Figure("sizes.png", "quad-comb", draw_effect_sizes),
    Figure("effects.png", "auv-dive", draw_effects),
    Figure("vehicle.png", "quad-calibration", draw_vehicle),
)
COVERAGE = Figure("coverage.png", "quad-calibration", draw_first_look)
SHORT = {
    "auv-spiral-excited": ("phases.0.run_in_s=10", "phases.0.duration_s=60"),
    "quad-comb": ("phases.0.lines=2", "phases.0.line_length_m=30", "phases.0.run_in_s=5"),
    "tumble": ("phases.0.duration_s=60",),
    "auv-dive": (
        *("phases.0.to_depth_m=8", "phases.1.run_in_s=10", "phases.1.duration_s=60", "phases.1.turns="),
        *("phases.2.lines=2", "phases.2.line_length_m=30", "phases.2.run_in_s=5", "phases.3.to_depth_m=3"),
    ),
    "quad-calibration": ("phases.0.duration_s=5", "phases.1.duration_s=40", "phases.2.duration_s=5"),
}
"""What cuts a scenario short."""


def names() -> dict[str, list[str]]:
    """What the tables hold today."""
    return {"effects": [cls.name for cls in EFFECTS], "calibrators": list(CALIBRATORS), "vehicles": list(VEHICLES)}


def kept() -> dict[str, Any]:
    """What `make pictures` wrote."""
    found: dict[str, Any] = json.loads(FILE.read_text(encoding="utf-8"))
    return found


def keep(diagnosed: Mapping[str, Shown], method: Mapping[str, Shown], viewed: Mapping[str, str]) -> None:
    """Write what the pictures show now: the verdicts', the method's, and the viewer's made now, each of a scenario.

    A picture that the viewer did not make anew is as old as it was, and the test run says so.
    """
    found = reports()
    views = kept().get("views", {}) | {
        file: {"scenario": scenario, "shows": found[scenario]} for file, scenario in viewed.items()
    }
    drift = {
        fit: [[*map(_rounded, seed)] for seed in seeds] for fit, seeds in reproduced.rms_nT(reproduced.FEW).items()
    }
    made = {"names": names(), "reports": found, "views": views, "reproduced": drift, "verdicts": diagnosed}
    made |= {"method": method}
    FILE.write_text(json.dumps(made, indent=1) + "\n", encoding="utf-8")


def reports() -> dict[str, Shown]:
    """What each figure of a report shows of its scenario cut short, and each scenario's calibrations and scores."""
    found: dict[str, Shown] = {}
    with tempfile.TemporaryDirectory() as folder:
        for scenario, cuts in SHORT.items():
            outcome = judged(load(scenario, list(cuts)), Path(folder) / scenario)
            found[scenario] = said(outcome)
            found |= {figure.file: shown(figure.draw, outcome) for figure in FIGURES if figure.scenario == scenario}
        found[COVERAGE.file] = shown(COVERAGE.draw, Path(folder) / COVERAGE.scenario)
    return found


def judged(scenario: Scenario, place: Path) -> Outcome:
    """A scenario run into a directory, calibrated and scored, without report and recording."""
    generate(scenario, place)
    return calibrate_and_score(scenario, *read_run(place))


def shown(draw: Callable[[Given], MplFigure], given: Given) -> dict[str, Any]:
    """What a figure holds: of each line, bar, area and cloud the number of values, mean and rms; the words."""
    with matplotlib.rc_context(STYLE):
        figure = draw(given)
        parts = {f"{number} {kind}": summed(values) for number, kind, values in _parts(figure)}
        return parts | {"words": _words(figure)}


def _parts(figure: MplFigure) -> Iterator[tuple[int, str, Any]]:
    for number, axis in enumerate(figure.axes):
        groups = {
            "line": [line.get_ydata() for line in axis.lines],
            "bar": [[bar.get_height(), bar.get_width()] for bar in axis.patches if isinstance(bar, Rectangle)],
            "cloud": [part.get_offsets() for part in axis.collections],
            "image": [image.get_array() for image in axis.images],
        }
        for kind, members in groups.items():
            for index, values in enumerate(members):
                yield number, f"{kind} {index}", values


def _words(figure: MplFigure) -> list[str]:
    """Titles, axes' names and legends, without their numbers."""
    texts = [
        text for axis in figure.axes for text in (axis.get_title(loc="left"), axis.get_xlabel(), axis.get_ylabel())
    ]
    texts += [label for axis in figure.axes for label in axis.get_legend_handles_labels()[1]]
    return [without_numbers(text) for text in texts if text]


def without_numbers(text: str) -> str:
    """A text with a mark for each number in it."""
    return re.sub(r"[-+]?\d[\d.,]*(?:e[-+]?\d+)?", "#", text)


def summed(values: Any) -> list[float]:
    """Number of finite values, their mean and rms."""
    array = np.ma.filled(np.ma.asarray(values, dtype=float), np.nan).ravel()
    finite = array[np.isfinite(array)]
    if not finite.size:
        return [0]
    return [finite.size, _rounded(finite.mean()), _rounded(np.sqrt(np.mean(finite**2)))]


def _rounded(value: float) -> float:
    return float(f"{value:.6g}")


def said(outcome: Outcome) -> dict[str, Any]:
    """Each calibrator's status; of one that is ok the size of its offset and its scores too, but for its time.

    What a motion does not tell comes out otherwise on every processor.
    """
    return {name: [fit.status.kind, *_values(outcome, name)] for name, fit in outcome.calibrations.items()}


def _values(outcome: Outcome, name: str) -> list[float]:
    fit = outcome.calibrations[name]
    if fit.status.kind != "ok":
        return []
    scores = [score.value for score in outcome.scores[name] if score.name != "wall_time"]
    return [_rounded(value) for value in (float(np.linalg.norm(fit.offset_nT)), *scores) if math.isfinite(value)]


def changed(old: Shown, new: Shown) -> list[str]:
    """The parts that are not what they were; parts that came since are none."""
    return [name for name, value in old.items() if name not in new or not _same(value, new[name])]


def _same(one: Any, other: Any) -> bool:
    if isinstance(one, list) and isinstance(other, list):
        return len(one) == len(other) and all(map(_same, one, other))
    if isinstance(one, int | float) and isinstance(other, int | float):
        return math.isclose(one, other, rel_tol=TOLERANCE, abs_tol=1e-9)
    return bool(one == other)
