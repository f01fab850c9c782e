"""What a selection of inputs leaves open, in words."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from calib.held_out.input_models import InputModels, least_squares_covariance
from calib.held_out.paired_legs import ModelPair
from calib.held_out.selection import UPGRADES, InputChoice
from calib.models.inputs import InputGroup, axis_columns, correlation
from calib.numerics.colour import inflation
from calib.observability import MAX_STD_FRACTION
from scenarios.text import figure

SURVIVES = 0.3
"""Least share of an input's changes that offset and matrix cannot follow; an input below follows the attitude."""
SURE = 2.0
"""Standard deviations of an input's field that cannot be excluded."""
TOGETHER = 0.99
"""Correlation from which on two motors' currents change together."""


def missing_excitation(models: InputModels, choice: InputChoice, groups: Sequence[InputGroup]) -> str:
    """Why no current or command of the log can be judged; "" where one is in use, or would have been seen."""
    power = [one for one in groups if one.kind != "temperature"]
    if choice.power is not None or not power:
        return ""
    reasons = [_lost(models, choice, one) for one in power if one.kind not in UPGRADES] or [""]
    return "; ".join(reasons) + "; fly with more and with less thrust" if all(reasons) else ""


def _lost(models: InputModels, choice: InputChoice, group: InputGroup) -> str:
    """Why a field of MAX_STD_FRACTION of the Earth's, at an input's largest value, would be missed; "" if seen."""
    if not group.varies:
        middle, span = float(np.median(group.signals[:, 0])), float(group.span[0])
        what = f"{group.called} stays at {figure(middle)} (within {figure(span, 2)})"
        return f"{what}: its field cannot be told from the offset"
    hidden_nT = SURE * uncertain_nT(models, choice, group)
    if hidden_nT <= MAX_STD_FRACTION * models.strength_nT:
        return ""
    share = surviving(models, group)
    why = "follows the attitude" if share < SURVIVES else "varies too little"
    limit = f"a field of {figure(hidden_nT)} nT at its largest value cannot be excluded"
    return f"{group.called} {why} ({figure(100 * share, 2)} % of its changes do not look like iron): {limit}"


def uncertain_nT(models: InputModels, choice: InputChoice, group: InputGroup) -> float:
    """Standard deviation of a group's field at its largest values, were it in the model; nT, in the worst direction."""
    model = models.model((*choice.groups, group), eddy=choice.eddy)
    first = 3 + len(model.slots) + 3 * sum(len(one.channels) for one in choice.groups)
    rows = slice(first, first + 3 * len(group.channels))
    _, covariance = least_squares_covariance(model)
    reach = np.repeat(np.abs(group.signals).max(axis=0), 3)
    largest = float(np.linalg.eigvalsh(covariance[rows, rows] * np.outer(reach, reach))[-1])
    return models.strength_nT * float(np.sqrt(largest * inflation(model.misfit())))


def surviving(models: InputModels, group: InputGroup) -> float:
    """Share of a group's changes that offset and matrix cannot follow: rms of the residual over rms."""
    model = models.iron
    _, J = model.linear()
    moved = group.moved(models.time_s)[models.rows]
    columns = axis_columns(moved - moved.mean(axis=0))
    seen = columns if model.known is not None else _normals(J) @ columns
    flat, iron = seen.reshape(-1, seen.shape[2]), J.reshape(-1, J.shape[2])
    left = flat - iron @ np.linalg.lstsq(iron, flat, rcond=None)[0]
    return float(np.sqrt(np.sum(left**2) / np.sum(flat**2)))


def _normals(J: np.ndarray) -> np.ndarray:
    """The normals (n, 1, 3), which are the columns of the offset."""
    return J[:, :, :3]


def caveat(models: InputModels, choice: InputChoice, groups: Sequence[InputGroup]) -> str:
    """What a user should know of a fit that is ok."""
    told = [_doubt(one) for one in choice.doubtful]
    if choice.power is None:
        doubtful = [one.called for one in choice.doubtful]
        tried = [one.called for one in groups if one.kind != "temperature" and one.called not in doubtful]
        if tried:
            told.append(f"no current or command changes the field on unseen legs ({', '.join(tried)}): no term of them")
    else:
        told += _rivals(models, choice, choice.power, groups)
    return "; ".join(told)


def _doubt(group: InputGroup) -> str:
    return f"{group.called} predicts unseen legs better, but any slow signal would: the cause may be a drift; left out"


def _rivals(models: InputModels, choice: InputChoice, power: InputGroup, groups: Sequence[InputGroup]) -> list[str]:
    """Inputs that predict unseen legs as well as the one in use, and motors that change together."""
    told = []
    for group in groups:
        if group.kind in ("temperature", power.kind) or not group.varies:
            continue
        if UPGRADES.get(group.kind) == power.kind:
            told += _together(group)
        elif len(group.channels) == len(power.channels) and not _worse(models, choice, power, group):
            alike = abs(correlation(group.signals[:, 0], power.signals[:, 0]))
            told.append(f"{group.called} predicts unseen legs as well as {power.called} (correlation {alike:.2f})")
    return told


def _worse(models: InputModels, choice: InputChoice, power: InputGroup, group: InputGroup) -> bool:
    """Whether a group in place of the one in use predicts unseen legs worse."""
    others = tuple(one for one in choice.groups if one is not power)
    model = models.model((*others, group), eddy=choice.eddy)
    return ModelPair(choice.errors, models.errors(model)).interval_nT[1] < 0


def _together(group: InputGroup) -> list[str]:
    """A caveat where the inputs of a group are one up to a factor."""
    pairs = [abs(correlation(group.signals[:, 0], other)) for other in group.signals.T[1:]]
    if min(pairs) < TOGETHER:
        return []
    return [f"{group.called} change together (correlation {min(pairs):.3f}): the field of each cannot be told"]
