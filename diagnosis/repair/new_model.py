"""The new model: what was given with the named effects in it, as a scenario that the simulator runs."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from diagnosis.problem.linear import LinearProblem
from diagnosis.repair.chain import fitted_iron
from diagnosis.repair.iron import beside
from diagnosis.result import Named
from recordings.channels import HEIGHT
from scenarios.spec import FieldSpec
from sim.effects import Effects, as_tables
from sim.effects.base import Effect
from sim.effects.chain_position import insert_effects
from sim.effects.noise import WhiteNoise
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
"""The motions that a model without one gets: over the whole sphere; with motors where an effect needs their current."""


def patched(model: Model, named: Sequence[Named], problem: LinearProblem) -> Scenario:
    """The given model with the named effects; where its iron was not known, with iron that is fitted beside them too.

    A scenario keeps its vehicle and motion; its `vary` goes, for this is now one instrument.
    """
    new = [effect for one in named for effect in one.effects]
    given = (
        problem.effects if problem.iron_known else insert_effects(problem.effects, fitted_iron(beside(problem, new)))
    )
    if not any(isinstance(effect, WhiteNoise) for effect in given):
        own_nT = problem.sigma_nT if problem.level is None else problem.sigma_nT[:1]  # the dip has that of the level
        x, y, z = (float(std) for std in np.resize(own_nT, 3))
        new.append(WhiteNoise((x, y, z)))
    whole = _merged(insert_effects(given, new), problem.state)
    tables, order = as_tables(whole)
    changed = {"effects": Effects(tables), "effect_order": order}
    if isinstance(model, Scenario):
        return model.model_copy(update={**changed, **_without_own(model), **_read_anew(problem)})
    return Scenario.model_validate(
        {"name": model.name, "summary": model.summary, "field": _field(model, problem)} | _motion(whole) | changed
    )


def _without_own(model: Scenario) -> dict[str, Any]:
    """What a scenario says of its sensors' own effects and of what varies, taken out: `effects` says it all."""
    bare = tuple(one.model_copy(update={"kind": None, "effects": Effects()}) for one in model.sensors)
    return {"sensor": None, "sensors": bare, "vary": {}}


def _merged(effects: Sequence[Effect], state: State) -> list[Effect]:
    """The effects, where two of a name only add and differ in nothing but what they are linear in, as one."""
    out: list[Effect] = []
    for effect in effects:
        rest = _rest(effect)
        same = [i for i, other in enumerate(out) if other.name == effect.name and _rest(other) == rest]
        if same and _adds(effect, state):
            total = out[same[0]].coefficients() + effect.coefficients()
            out[same[0]] = effect.combine(total, **rest)
        else:
            out.append(effect)
    return out


def _adds(effect: Effect, state: State) -> bool:
    """Whether what an effect contributes does not depend on the signal; what chance makes is linear in nothing."""
    if not effect.linear:
        return False
    once, twice = (effect.apply(state, k * state.field_nT, np.random.default_rng(0), {}) for k in (1.0, 2.0))
    return bool((once == twice).all())


def _rest(effect: Effect) -> dict[str, Any]:
    """The parameters that an effect is not linear in, and its window."""
    return {name: getattr(effect, name) for name in effect.names() if name not in effect.linear}


def _read_anew(problem: LinearProblem) -> dict[str, Any]:
    """The field in place of a scenario's own, where that was wrong."""
    return {"field": FieldSpec(enu_nT=tuple(problem.instead[-1].field_enu_nT))} if problem.instead else {}


def _field(model: ModelSpec, problem: LinearProblem) -> Any:
    if problem.instead:
        return {"enu_nT": problem.instead[-1].field_enu_nT.tolist()}
    if model.field is None:
        return {"enu_nT": problem.state.field_enu_nT.tolist()}
    return model.field.model_dump(mode="json", exclude_none=True)


def _motion(effects: Sequence[Effect]) -> dict[str, Any]:
    given = (*channels_of(TABLE["vehicle"]["kind"]), HEIGHT)
    needed = {name for effect in effects for name in effect.required_inputs} - MOTION
    return TABLE if needed <= set(given) else CIRCLES
