"""The new model: the given model with the named effects, as a scenario for the simulator."""

from __future__ import annotations

import itertools
from collections.abc import Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from diagnosis.problem.linear import LinearProblem
from diagnosis.problem.model_effects import fitted_iron
from diagnosis.repair.chain import chain_residual, fit_iron_with_effects
from diagnosis.repair.refinement import refine
from diagnosis.result import NamedEffect
from recordings.channels import HEIGHT
from scenarios.errors import InputError
from scenarios.spec import FieldSpec, NavigationSpec
from sim.effects import Effects, as_tables, of_sign
from sim.effects.base import Effect
from sim.effects.chain_position import insert_effects
from sim.scenario import Model, ModelSpec, Scenario
from sim.simulation import channels_of
from sim.state import MOTION, State
from sim.vehicles.auv import Auv
from sim.vehicles.turntable import Turntable

TABLE: dict[str, Any] = {"vehicle": {"kind": Turntable.name}, "phases": [{"kind": "tumble", "duration_s": 380.0}]}
CIRCLES: dict[str, Any] = {
    "vehicle": {"kind": Auv.name},
    "phases": [
        {"kind": "spiral", "radius_m": 20.0, "turn_rate_deg_s": 1.0, "duration_s": 400.0,
         "roll_amplitude_deg": 20.0, "pitch_amplitude_deg": 25.0},
    ],
}  # fmt: skip
"""Motions for a model without one: over the whole sphere, or with motors where an effect needs their currents."""


class StandIn(Scenario):
    """A scenario whose vehicle and motion stand in for those of a log that does not tell them."""


def patch_model(model: Model, named: Sequence[NamedEffect], problem: LinearProblem) -> Scenario:
    """Add the named effects to the given model, with fitted iron where its iron was unknown.

    A scenario keeps its vehicle and motion, but not its `vary`: the new model is a single instrument. A model without
    a vehicle becomes a `StandIn`, which the simulator can run.
    """
    new = [effect for named_effect in named for effect in named_effect.effects]
    iron = () if problem.iron_known else fitted_iron(fit_iron_with_effects(problem, new))
    given = insert_effects(problem.effects, iron)
    if not any(effect.traits.sign == "white" for effect in given):
        own_nT = (
            problem.sigma_nT if problem.level is None else problem.sigma_nT[:1]
        )  # the dip has the noise of the strength
        x, y, z = (float(std) for std in np.resize(own_nT, 3))
        new.append(of_sign("white", (x, y, z)))
    whole = _as_one(_merge_equal(insert_effects(given, new), problem.state), problem)
    tables, order = as_tables(whole)
    changed = {"effects": Effects(tables), "effect_order": order}
    if isinstance(model, Scenario):
        return model.model_copy(update={**changed, **_single_instrument(model, problem)})
    return StandIn.model_validate(
        {"name": model.name, "summary": model.summary, "field": _field(model, problem)}
        | _motion(whole)
        | changed
        | _navigation(NavigationSpec(), problem)
    )


def _single_instrument(model: Scenario, problem: LinearProblem) -> dict[str, Any]:
    """Updates of a scenario: the corrected field, the attitude's delay, and sensors without effects and variations.

    The effects of its sensors are all included in `effects`.
    """
    bare = tuple(sensor.model_copy(update={"kind": None, "effects": Effects()}) for sensor in model.sensors)
    single = {"sensor": None, "sensors": bare, "vary": {}} | _navigation(model.navigation, problem)
    field_enu_nT = problem.corrected_field_enu_nT
    return single if field_enu_nT is None else single | {"field": FieldSpec(enu_nT=tuple(field_enu_nT))}


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


def _as_one(chain: Sequence[Effect], problem: LinearProblem) -> list[Effect]:
    """Join two effects of one name in a chain, if one effect with other parameters leaves no more of the gap.

    The model's lag and the lag named beside it are a single lag. Vector mode only.
    """
    joined = list(chain)
    if problem.mode == "vector" and not (problem.still or problem.relative):
        for own, change in _pairs(joined):
            joined = _joined(joined, own, change, problem)
    return joined


def _pairs(chain: Sequence[Effect]) -> list[tuple[Effect, Effect]]:
    """Effects of one name of which the chain has two, both linear in a size and acting throughout."""
    able = sorted((effect for effect in chain if effect.linear and effect.active_s is None), key=lambda one: one.name)
    of_name = (tuple(several) for _, several in itertools.groupby(able, key=lambda one: one.name))
    return [(several[0], several[1]) for several in of_name if len(several) == 2]


def _joined(chain: list[Effect], own: Effect, change: Effect, problem: LinearProblem) -> list[Effect]:
    others = [effect for effect in chain if effect is not own and effect is not change]
    about = replace(problem, effects=tuple(others), iron_known=True)
    try:
        sum_of_both = own.combine(own.coefficients() + change.coefficients(), **_nonlinear_values(own))
    except InputError:  # beyond the effect's bounds
        return chain
    (one,) = refine(about, [sum_of_both], problem.usable > 0, refit_iron=False).effects
    with_two, with_one = (float(np.square(chain_residual(about, new)).sum()) / 2 for new in ((own, change), (one,)))
    kept = (one if effect is own else effect for effect in chain if effect is not change)
    return list(kept) if with_one - with_two < problem.policy.apart else chain


def _is_additive(effect: Effect, state: State) -> bool:
    """Whether the contribution of an effect is independent of the signal; random effects have no linear parameter."""
    if not effect.linear:
        return False
    once, twice = (effect.apply(state, k * state.field_nT, np.random.default_rng(0), {}) for k in (1.0, 2.0))
    return bool((once == twice).all())


def _nonlinear_values(effect: Effect) -> dict[str, Any]:
    """The parameters in which an effect is not linear, and its window."""
    return {name: getattr(effect, name) for name in effect.names() if name not in effect.linear}


def _navigation(given: NavigationSpec, problem: LinearProblem) -> dict[str, Any]:
    """The navigation with the delay of the attitude that was found; nothing if there is none."""
    if problem.attitude_delay_s == given.attitude_delay_s:
        return {}
    return {"navigation": given.model_copy(update={"attitude_delay_s": problem.attitude_delay_s})}


def _field(model: ModelSpec, problem: LinearProblem) -> Any:
    if problem.corrected_field_enu_nT is not None:
        return {"enu_nT": problem.corrected_field_enu_nT.tolist()}
    if model.field is None:
        return {"enu_nT": problem.state.field_enu_nT.tolist()}
    return model.field.model_dump(mode="json", exclude_none=True)


def _motion(effects: Sequence[Effect]) -> dict[str, Any]:
    given = (*channels_of(TABLE["vehicle"]["kind"]), HEIGHT)
    needed = {name for effect in effects for name in effect.required_inputs} - MOTION
    return TABLE if needed <= set(given) else CIRCLES
