"""The new model: the given model with the named effects, its file, and the gap that the simulator leaves with it."""

from __future__ import annotations

import difflib
import itertools
import re
from collections.abc import Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from diagnosis.problem.formulation import simulated_nT
from diagnosis.problem.linear import LinearProblem
from diagnosis.repair.refinement import chain_residual, fit_iron_with_effects, refine
from diagnosis.result import NamedEffect
from recordings import Recording
from scenarios.errors import InputError
from scenarios.nesting import parsed_toml
from scenarios.spec import FieldSpec
from scenarios.toml import to_toml
from sim.effects import Effects, as_tables, of_sign
from sim.effects.base import Effect
from sim.effects.chain_position import insert_effects
from sim.scenario import Model, ModelSpec, Scenario
from sim.state import State
from validation.signals.amplitude import rms

NO_VEHICLE = "# The vehicle is unknown: `diagnose --model` takes the file; to simulate, add [vehicle] and [[phases]].\n"
DIGITS = 5
"""Significant digits of a number in the diff; the model's file has all."""
LONG_NUMBER = re.compile(r"-?\d+\.\d{4,}(?:e[+-]?\d+)?")


def patch_model(model: Model, named: Sequence[NamedEffect], problem: LinearProblem) -> Model:
    """Add the named effects to the given model, with fitted iron where its iron was unknown, and the field that holds.

    A scenario keeps its vehicle and motion, but not its `vary`: the new model is a single instrument.
    """
    new = [effect for cause in named for effect in cause.effects]
    iron = () if problem.iron_known else fit_iron_with_effects(problem, new).fitted_iron
    given = insert_effects(problem.effects, iron)
    if not any(effect.traits.sign == "white" for effect in given):
        # without a heading the second quantity is the dip, which has the noise of roll and pitch too
        own_nT = problem.sigma_nT if problem.level is None else problem.sigma_nT[:1]
        new.append(of_sign("white", tuple(np.resize(own_nT, 3).tolist())))
    whole = _as_one(_merge_equal(insert_effects(given, new), problem.state), problem)
    return _with_effects(model, whole, problem)


def _with_effects(model: Model, effects: Sequence[Effect], problem: LinearProblem) -> Model:
    """A model with other effects, and with the field and the attitude's delay of a problem."""
    tables, order = as_tables(effects)
    navigation = (model if isinstance(model, Scenario) else ModelSpec()).navigation
    late = navigation.model_copy(update={"attitude_delay_s": problem.attitude_delay_s})
    changed = {"effects": Effects(tables), "effect_order": order, "navigation": late}
    if (corrected_nT := problem.corrected_field_enu_nT) is not None:
        changed["field"] = FieldSpec(enu_nT=tuple(corrected_nT))
    elif model.field is None:
        changed["field"] = FieldSpec(enu_nT=tuple(problem.state.field_enu_nT))
    if isinstance(model, Scenario):  # whose sensors' own effects are all in `effects`
        bare = tuple(sensor.model_copy(update={"kind": None, "effects": Effects()}) for sensor in model.sensors)
        changed |= {"sensor": None, "sensors": bare, "vary": {}}
    return model.model_copy(update=changed)


def _merge_equal(effects: Sequence[Effect], state: State) -> list[Effect]:
    """Merge additive effects of one name that differ only in their linear parameters."""
    merged: list[Effect] = []
    for effect in effects:
        nonlinear = _nonlinear_values(effect)
        equal = [i for i, e in enumerate(merged) if e.name == effect.name and _nonlinear_values(e) == nonlinear]
        if equal and _is_additive(effect, state):
            total = merged[equal[0]].coefficients() + effect.coefficients()
            merged[equal[0]] = effect.combine(total, **nonlinear)
        else:
            merged.append(effect)
    return merged


def _is_additive(effect: Effect, state: State) -> bool:
    """Whether the contribution of an effect is independent of the signal; random effects have no linear parameter."""
    once, twice = (effect.apply(state, k * state.field_nT, np.random.default_rng(0), {}) for k in (1.0, 2.0))
    return bool(effect.linear) and bool((once == twice).all())


def _as_one(chain: Sequence[Effect], problem: LinearProblem) -> list[Effect]:
    """Join two effects of one name, as the model's lag and a lag named beside it, if one leaves no more of the gap."""
    joined = list(chain)
    for own, change in _pairs(joined, problem):
        others = [effect for effect in joined if effect is not own and effect is not change]
        about = replace(problem, effects=tuple(others), iron_known=True)
        try:
            sum_of_both = own.combine(own.coefficients() + change.coefficients(), **_nonlinear_values(own))
        except InputError:  # beyond the effect's bounds
            continue
        one, _ = refine(about, [sum_of_both], problem.usable > 0, refit_iron=False)
        of_two, of_one = (float(np.square(chain_residual(about, new)).sum()) / 2 for new in ((own, change), one))
        if of_one - of_two < problem.policy.apart:
            joined = [one[0] if effect is own else effect for effect in joined if effect is not change]
    return joined


def _pairs(chain: Sequence[Effect], problem: LinearProblem) -> list[tuple[Effect, Effect]]:
    """Effects of one name of which the chain has two, both linear in a size and acting throughout."""
    if not problem.along_attitude:
        return []
    able = sorted((effect for effect in chain if effect.linear and effect.active_s is None), key=lambda one: one.name)
    of_name = (tuple(several) for _, several in itertools.groupby(able, key=lambda one: one.name))
    return [(several[0], several[1]) for several in of_name if len(several) == 2]


def _nonlinear_values(effect: Effect) -> dict[str, Any]:
    """The parameters in which an effect is not linear, and its window."""
    return {name: getattr(effect, name) for name in effect.names() if name not in effect.linear}


def written_model(model: Model) -> str:
    """The TOML text of a new model: a scenario, or what a diagnosis compares where the vehicle is not known."""
    return to_toml(model) if isinstance(model, Scenario) else NO_VEHICLE + to_toml(model)


def resimulated_rms_nT(recording: Recording, model: Model, end: LinearProblem) -> float | None:
    """Rms in nT of measured minus simulated for a model read back from its TOML text, with no fit to the recording.

    recording : with its attitude as recorded. end : the problem at the end of the diagnosis, whose usable samples are
    counted. None where the three axes are not compared with the Earth's field.
    """
    if not end.along_attitude or len(end.usable) != len(recording):
        return None
    read = type(model).model_validate(parsed_toml(written_model(model), "model.toml", "report the model"))
    return rms((recording.mag_nT - simulated_nT(recording, read, end.policy))[np.asarray(end.usable > 0)])


def lines_of_diff(given_effects: Sequence[Effect], model: Model) -> tuple[str, ...]:
    """Lines of the diff from the effects of the given model to a new model, without line ends; empty if equal."""
    tables, order = as_tables(tuple(given_effects))
    given = model.model_copy(update={"effects": Effects(tables), "effect_order": order})
    before, after = _compared(given), _compared(model)
    return tuple(difflib.unified_diff(before, after, "given model", "new model", lineterm="", n=2))


def _compared(model: Model) -> list[str]:
    """Lines of what a diagnosis compares, the field and the effects, with numbers of DIGITS significant digits."""
    head, *tables = re.split(r"^(?=\[)", to_toml(model), flags=re.MULTILINE)
    order = [line for line in head.splitlines() if line.startswith("effect_order")]
    text = "\n".join([*order, "", *(one for one in tables if one.startswith(("[field", "[effects", "[[effects")))])
    return LONG_NUMBER.sub(lambda number: f"{float(number[0]):.{DIGITS}g}", text).splitlines()
