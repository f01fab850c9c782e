"""Trials and rows of the rivals that [Li2017] cites, beside the paper's filter: simulation of table 1, and survey."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from calib.models.vector import VectorData
from papers.base import PaperRow, spread_text
from papers.judgement import claim, incomparable
from papers.li2017.rivals import RIVALS, TurnedField, truncated_state
from papers.li2017.rows import COMPONENTS_NT, MOST_TOTAL_NT, Trials, listed
from papers.li2017.trials import (
    EDDY_S,
    FIELD_ENU_NT,
    REFERENCE,
    TRUE_STATE,
    TRUNCATED,
    Survey,
    compensated,
    simulated,
    turning,
)
from scenarios.arrays import Array
from validation.text import figure

POOR_NT = 10 * COMPONENTS_NT[1][0]
"""Component error that is poor: ten times the largest that the paper prints of its filter."""
EDDIES = ("without eddy currents", "with eddy currents")


@dataclass(frozen=True, eq=False)
class RivalErrors:
    """Mean absolute errors over the run, without noise, by rival and EDDIES.

    strength_nT: of the strength; component_nT: of the components (3,); truncated_nT (3,): of the components after
    truncated total least squares of eq. 1, all 21 parameters, with eddy currents.
    """

    strength_nT: dict[tuple[str, str], float]
    component_nT: dict[tuple[str, str], Array]
    truncated_nT: Array


def rival_trial(seed: int) -> RivalErrors:
    """Run every rival on the noise of `filter_trial`, on table 1 as printed and with B = 0, the rivals' own model."""
    data = simulated(seed)
    clean = replace(data, difference_nT=data.observation() @ TRUE_STATE)
    error = compensated(truncated_state(data), clean) - data.field_nT
    found = RivalErrors({}, {}, np.abs(error).mean(axis=0))
    up = turning(len(data.field_nT)).R_wb[:, 2]
    for eddies, share in zip(EDDIES, (0.0, 1.0), strict=True):
        measured, exact = (_measured(one, share) for one in (data, clean))
        for name, rival in RIVALS.items():
            field = rival(TurnedField(measured, up, np.array(FIELD_ENU_NT), seed)).apply(exact)
            strength = np.linalg.norm(field, axis=1) - REFERENCE.strength_nT
            found.strength_nT[name, eddies] = float(np.abs(strength).mean())
            found.component_nT[name, eddies] = np.abs(field - data.field_nT).mean(axis=0)
    return found


def _measured(data: VectorData, share: float) -> Array:
    """Return T_m (n, 3), nT, with a share of the eddy currents that `data` holds."""
    return np.asarray(data.field_nT + data.difference_nT - (1.0 - share) * data.rate_nT_s @ np.array(EDDY_S).T)


def rival_rows(found: list[RivalErrors], trials: Trials, surveys: list[Survey]) -> list[PaperRow]:
    """Return the rows on each rival's totals and components, on eddy currents, and beside the filter."""
    return [
        *(_totals_and_components(found, name) for name in RIVALS),
        _eddies(found),
        _beside_filter(found, trials),
        _survey(surveys),
    ]


def _strength(found: list[RivalErrors], name: str, eddies: str) -> Array:
    return np.array([one.strength_nT[name, eddies] for one in found])


def _components(found: list[RivalErrors], name: str, eddies: str) -> Array:
    """Return the component errors (3,) of a rival, medians over the seeds."""
    return np.asarray(np.median([one.component_nT[name, eddies] for one in found], axis=0))


def _totals_and_components(found: list[RivalErrors], name: str) -> PaperRow:
    none = EDDIES[0]
    strength, component = _strength(found, name, none), _components(found, name, none)
    note = (
        "a product with the vertical holds the direction too: it is no constraint of the total field"
        if name == "dot product"
        else "the field's strength says nothing of a rotation, and I + A of table 1 is not symmetric"
    )
    return PaperRow(
        f"{name} {none}: error of the strength, and of components x, y, z",
        "works well for totals, poorly for components",
        f"{spread_text(strength, 'nT')}; {listed(component)} nT (medians)",
        claim(
            np.median(strength) < MOST_TOTAL_NT and component.max() > POOR_NT,
            f"strength below {MOST_TOTAL_NT:g} nT, largest component above {POOR_NT:.0f} nT",
            "the printed total of the filter, and ten times its largest component",
        ),
        f"table 1 with B = 0, the model of the rivals; method cited without a figure, layout ours. {note}",
    )


def _eddies(found: list[RivalErrors]) -> PaperRow:
    without, held = ({name: float(np.median(_strength(found, name, eddies))) for name in RIVALS} for eddies in EDDIES)
    return PaperRow(
        "the same rivals with table 1's eddy currents: error of the strength",
        "eddy currents limit the accuracy, not to be neglected",
        "; ".join(f"{name} {figure(held[name])} nT (without {figure(without[name], 2)})" for name in RIVALS),
        claim(
            all(held[name] > 2 * without[name] for name in RIVALS),
            "more than doubled for every rival",
            "limit has no number; a doubling is beyond the seeds' scatter",
        ),
        "the paper calls the eddy field small; table 1's B of up to 0.61 s makes thousands of nT at 0.5 rad/s",
    )


def _beside_filter(found: list[RivalErrors], trials: Trials) -> PaperRow:
    truncated = np.array([one.truncated_nT.max() for one in found])
    proposed, constant = (np.array([t[name].component_nT.max() for t in trials]) for name in ("both", "constant"))
    return PaperRow(
        f"{TRUNCATED}, all 21 parameters: largest component error",
        "cited, no figure",
        f"{spread_text(truncated, 'nT')}; the proposed filter {spread_text(proposed, 'nT')}",
        incomparable("the paper names the method and runs it on no equations of its own"),
        "the filter's own equations and data, all samples alike: what the filter loses is what Q = 1e-5 makes the "
        f"filter forget (with Q = 0 {spread_text(constant, 'nT')})",
    )


def _survey(surveys: list[Survey]) -> PaperRow:
    names = {name: name for name in (*RIVALS, TRUNCATED)} | {"proposed": "kalman_fuzzy"}
    rms = {shown: np.mean([s.rms_nT[name] for s in surveys], axis=0) for shown, name in names.items()}
    return PaperRow(
        "quadrotor: the rivals beside the proposed filter, component rms x, y, z",
        "cited, no figure",
        "; ".join(f"{name.replace('kalman_fuzzy', 'proposed')} {listed(values)}" for name, values in rms.items())
        + " nT",
        incomparable("the paper flies no rival but Levenberg-Marquardt"),
        "flown in MuJoCo, level and on few headings: what a rival's own equation leaves open there stays as measured",
    )
