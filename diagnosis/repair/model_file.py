"""The new model as a file: its text, its change as a unified diff, and the gap that the simulator leaves with it."""

from __future__ import annotations

import difflib
import re
from collections.abc import Sequence

import numpy as np

from diagnosis.problem.formulation import simulated_nT
from diagnosis.problem.linear import LinearProblem
from diagnosis.repair.new_model import StandIn
from diagnosis.result import Diagnosis
from recordings import Recording
from scenarios.nesting import parsed_toml
from scenarios.spec import NavigationSpec
from scenarios.toml import to_toml
from sim.effects import Effects, as_tables
from sim.effects.base import Effect
from sim.scenario import ModelSpec, Scenario
from validation.signals.amplitude import rms

NO_VEHICLE = "# The vehicle is unknown: `diagnose --model` takes the file; to simulate, add [vehicle] and [[phases]].\n"
DIGITS = 5
"""Significant digits of a number in the diff; the model's file has all."""
LONG_NUMBER = re.compile(r"-?\d+\.\d{4,}(?:e[+-]?\d+)?")


def written_model(model: Scenario) -> str:
    """The TOML text of a new model: a scenario, or what a diagnosis compares where the vehicle is not known."""
    if not isinstance(model, StandIn):
        return to_toml(model)
    kept = {name: getattr(model, name) for name in ("name", "summary", "field", "effects", "effect_order")}
    late = NavigationSpec(attitude_noise_std_deg=0.0, attitude_delay_s=model.navigation.attitude_delay_s)
    return NO_VEHICLE + to_toml(ModelSpec(navigation=late, **kept))


def resimulated_rms_nT(recording: Recording, model: Scenario, end: LinearProblem) -> float | None:
    """Rms in nT of measured minus simulated for a model read back from its TOML text, with no fit to the recording.

    recording : with its attitude as recorded. end : the problem at the end of the diagnosis, whose usable samples are
    counted. None where the three axes are not compared with the Earth's field.
    """
    if end.mode != "vector" or end.still or end.relative or len(end.usable) != len(recording):
        return None
    kind = ModelSpec if isinstance(model, StandIn) else Scenario
    read = kind.model_validate(parsed_toml(written_model(model), "model.toml", "report the model"))
    return rms((recording.mag_nT - simulated_nT(recording, read, end.policy))[np.asarray(end.usable > 0)])


def model_diff(diagnosis: Diagnosis) -> tuple[str, ...]:
    """Lines of the diff from the given model to the new one, without line ends; empty if nothing was added."""
    return lines_of_diff(diagnosis.given, diagnosis.model)


def lines_of_diff(given_effects: Sequence[Effect], model: Scenario) -> tuple[str, ...]:
    """Lines of the diff from the effects of the given model to a new model."""
    tables, order = as_tables(tuple(given_effects))
    given = model.model_copy(update={"effects": Effects(tables), "effect_order": order})
    before, after = _compared(given), _compared(model)
    return tuple(difflib.unified_diff(before, after, "given model", "new model", lineterm="", n=2))


def _compared(model: Scenario) -> list[str]:
    """Lines of what a diagnosis compares, the field and the effects, with numbers of DIGITS significant digits."""
    head, *tables = re.split(r"^(?=\[)", to_toml(model), flags=re.MULTILINE)
    order = [line for line in head.splitlines() if line.startswith("effect_order")]
    compared = (table for table in tables if table.startswith(("[field", "[effects", "[[effects")))
    text = "\n".join([*order, "", *compared])
    return LONG_NUMBER.sub(lambda number: f"{float(number[0]):.{DIGITS}g}", text).splitlines()
