"""Stepwise selection of inputs by their gain on legs that no fit has seen."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace

import numpy as np
from scipy.optimize import minimize_scalar

from calib.held_out.input_models import InputModels, linearly_held_out
from calib.held_out.paired_legs import HeldOutErrors, ModelPair
from calib.held_out.surrogates import surrogates
from calib.models.inputs import InputGroup, axis_columns

QUICK_LAGS_S, SLOW_LAGS_S = (0.03, 0.1, 0.3, 1.0, 3.0), (10.0, 30.0, 100.0, 300.0)
"""Lags that are tried for currents and commands, and for a temperature; the best is then refined."""
REFINED = 2.0
"""Factor about the best tried lag within which it is refined."""
LEAST_FALL = 0.01
"""Fall of the cost, in parts, from which on a lag is worth a held-out fit."""
UPGRADES = {"motors": "battery", "outputs": "throttle"}
"""Kinds of several inputs, and the kind of the one input that they replace."""
WORTH = "worth_it"


@dataclass(frozen=True, eq=False)
class InputChoice:
    """Inputs in use, whether eddy currents are, and the held-out errors of their model.

    doubtful : inputs whose gain any slow signal would give
    """

    groups: tuple[InputGroup, ...]
    eddy: bool
    errors: HeldOutErrors
    doubtful: tuple[InputGroup, ...] = ()

    @property
    def power(self) -> InputGroup | None:
        """The group of currents or commands in use."""
        return next((one for one in self.groups if one.kind != "temperature"), None)


def selected(models: InputModels, groups: Sequence[InputGroup], *, lags: bool) -> InputChoice:
    """Add what predicts unseen legs better, the greatest gain first, until nothing does.

    One input at a time, and then each motor in place of their sum, where that is better still. An input needs a gain
    whose 95 % interval is above zero, however small: what moves the field little in one flight may move it much in
    another. Eddy currents need a gain that matters too. lags : whether a lag behind the input is tried.
    """
    now = InputChoice((), eddy=False, errors=models.errors(models.iron))
    while True:
        better = [one for one in _steps(models, now, groups, lags) if _gains(now, one)]
        if not better:
            return now
        simple = [one for one in better if all(len(group.channels) == 1 for group in one.groups)]
        best = min(simple or better, key=lambda one: one.errors.typical_nT)
        now = _believed(models, now, _refined(models, now, best) if lags else best)
        groups = [one for one in groups if all(one.channels != doubt.channels for doubt in now.doubtful)]


def _gains(simpler: InputChoice, richer: InputChoice) -> bool:
    """Whether the richer choice predicts unseen legs better."""
    pair = ModelPair(simpler.errors, richer.errors)
    return pair.verdict == WORTH if richer.eddy and not simpler.eddy else pair.interval_nT[0] > 0


def _steps(models: InputModels, now: InputChoice, groups: Sequence[InputGroup], lags: bool) -> Iterator[InputChoice]:
    """Each choice that is one step richer."""
    if models.rate_rad_s is not None and not now.eddy:
        yield _made(models, now, now.groups, eddy=True)
    for group in groups:
        kept = tuple(one for one in now.groups if one.kind != UPGRADES.get(group.kind))
        if _allowed(now, kept, group):
            plain = _made(models, now, (*kept, group), eddy=now.eddy)
            lag_s = _best_lag(models, now, group) if lags else 0.0
            late = _made(models, now, (*kept, replace(group, lag_s=lag_s)), eddy=now.eddy) if lag_s else plain
            yield late if _gains(plain, late) else plain


def _allowed(now: InputChoice, kept: tuple[InputGroup, ...], group: InputGroup) -> bool:
    """Whether a group may be added: one of currents and commands, and none that hardly varies."""
    if not group.varies or any(one.channels == group.channels for one in now.groups):
        return False
    return group.kind == "temperature" or all(one.kind == "temperature" for one in kept)


def _made(models: InputModels, now: InputChoice, groups: tuple[InputGroup, ...], *, eddy: bool) -> InputChoice:
    return replace(now, groups=groups, eddy=eddy, errors=models.errors(models.model(groups, eddy=eddy)))


def _best_lag(models: InputModels, now: InputChoice, group: InputGroup) -> float:
    """The best tried lag, s, by the cost of the linearised model; 0 where the cost hardly falls."""
    tried = SLOW_LAGS_S if group.kind == "temperature" else QUICK_LAGS_S
    least_s, most_s = np.median(np.diff(models.time_s)), np.ptp(models.time_s) / 5.0
    costs = {lag_s: _lag_cost(models, now, group, lag_s) for lag_s in (0.0, *tried) if lag_s <= most_s}
    best = min(costs, key=lambda lag_s: costs[lag_s])
    return best if best >= least_s and costs[best] < (1.0 - LEAST_FALL) * costs[0.0] else 0.0


def _lag_cost(models: InputModels, now: InputChoice, group: InputGroup, lag_s: float) -> float:
    columns = models.columns(replace(group, lag_s=lag_s))
    return linearly_held_out(now.errors.model, columns, models.legs)[0]


def _refined(models: InputModels, now: InputChoice, best: InputChoice) -> InputChoice:
    """The choice with the lag of its last group refined."""
    *kept, group = best.groups or (None,)
    if group is None or not group.lag_s or best.groups == now.groups:
        return best
    edges = np.log(group.lag_s) + np.log(REFINED) * np.array([-1.5, 1.5])
    found = minimize_scalar(
        lambda log_s: _lag_cost(models, now, group, float(np.exp(log_s))),
        bounds=edges,
        method="bounded",
        options={"xatol": 0.01},
    )
    finer = replace(group, lag_s=float(f"{np.exp(found.x):.3g}"))
    return _made(models, best, (*(one for one in kept if one is not None), finer), eddy=best.eddy)


def _believed(models: InputModels, now: InputChoice, best: InputChoice) -> InputChoice:
    """The richer choice; the present one, with a doubt, where a signal of the same spectrum gains as much."""
    added = [one for one in best.groups if one not in now.groups]
    if len(added) != 1 or len(added[0].channels) != 1:
        return best
    signal = added[0].moved(models.time_s)[models.rows, 0]
    own = linearly_held_out(now.errors.model, axis_columns(signal[:, None]), models.legs)[1]
    for other in surrogates(signal):
        if linearly_held_out(now.errors.model, axis_columns(other[:, None]), models.legs)[1] <= own:
            return replace(now, doubtful=(*now.doubtful, added[0]))
    return best
