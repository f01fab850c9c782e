"""Rows of [Zhou2012]: five values, convergence, and observability from a turn about the vertical."""

from __future__ import annotations

import numpy as np

from calib.models.turntable import NAMES
from papers.base import PaperRow, spread_text
from papers.judgement import claim, incomparable
from papers.zhou2012.separate import ALONE
from papers.zhou2012.trials import JOINT, NOISE_NT, OFFSET_NT, PRINTED, STABLE_AT, ZhouTrial, bound
from scenarios.arrays import Array
from sim.state import State
from validation.text import figure


def rows(clean: list[ZhouTrial], shifted: list[ZhouTrial], state: State) -> tuple[PaperRow, ...]:
    """Return the rows on the estimates without a sensor offset, and with an offset outside the model."""
    return (
        *_values(clean, bound(state), state),
        _stable(clean),
        _flat(clean),
        *_separate(clean),
        _weakest(clean, state),
        _offset(clean, shifted, state),
    )


def _values(trials: list[ZhouTrial], limit: Array, state: State) -> list[PaperRow]:
    found = np.array([t.found for t in trials])
    error = np.sqrt(np.mean((found - PRINTED) ** 2, axis=0))
    level, up = np.hypot(*state.field_enu_nT[:2]), state.field_enu_nT[2]
    where = f"field {level:.0f} nT level, {up:.0f} nT up; noise {NOISE_NT:g} nT"
    own = np.mean([t.claimed for t in trials], axis=0)
    # the rms of n errors scatters by 1 / sqrt(2 n): three of that above the bound
    slack = 1.0 + 3.0 / np.sqrt(2 * len(trials))
    rows = []
    for k, name in enumerate(NAMES):
        note = (
            f"rms error {figure(error[k])} over {len(trials)} seeds: {error[k] / own[k]:.2f} of what the noise does to "
            f"the minimum of this objective (Jacobian), {figure(own[k])}; Cramer-Rao bound {figure(limit[k])}"
        )
        if own[k] > 1.1 * limit[k]:
            note += (
                f". The objective gives away a factor {own[k] / limit[k]:.2f}: it weights z and the total as if "
                "their noises were independent, and they share the noise of z"
            )
        rows.append(
            PaperRow(
                f"{name} found again ({where})",
                f"{PRINTED[k]:.6f}",
                f"{found[:, k].mean():.6f} ± {figure(found[:, k].std(), 2)}",
                claim(
                    error[k] <= slack * own[k],
                    f"rms error within {slack:.2f} of the noise's effect",
                    f"three standard deviations of an rms of {len(trials)} seeds",
                ),
                note,
            )
        )
    return rows


def _stable(trials: list[ZhouTrial]) -> PaperRow:
    rms = np.array([t.history for t in trials])
    objective = rms**2
    share = objective[:, STABLE_AT - 1] / objective[:, 0]
    within = np.array([int(np.argmax(o <= 1.01 * o[-1])) + 1 for o in objective])
    return PaperRow(
        "objective against iterations (N 25, F_w 0.85, P_c 1, bounds ±0.2)",
        f"stable after about {STABLE_AT}",
        f"at {STABLE_AT}: {figure(np.median(share), 2)} of the start (95 %: {figure(np.quantile(share, 0.95), 2)})",
        claim(
            np.quantile(share, 0.95) < 0.01,
            "95 % of seeds below 1 % of the start",
            "a line's width on the paper's axis",
        ),
        f"flat on the paper's linear axis; the noise floor (within 1 % of the end) is reached at iteration "
        f"{np.median(within):.0f} (5 to 95 %: {np.quantile(within, 0.05):.0f} to {np.quantile(within, 0.95):.0f})",
    )


def _flat(trials: list[ZhouTrial]) -> PaperRow:
    before, after = np.ptp([t.z_nT for t in trials], axis=1), np.ptp([t.flat_nT for t in trials], axis=1)
    # twelve normal deviates range over 3.26 standard deviations, on average
    return PaperRow(
        "z output over the turn, largest less smallest",
        "varies before, flat after (figure, no number)",
        f"{np.median(before):.0f} nT before, {np.median(after):.1f} nT after (median)",
        claim(
            np.median(after) < 4.0 * NOISE_NT,
            f"{4.0 * NOISE_NT:g} nT",
            "the range of twelve noises is 3.3 times one",
        ),
        f"noise of {NOISE_NT:g} nT alone gives 3.3 nT",
    )


def _separate(trials: list[ZhouTrial]) -> list[PaperRow]:
    error = {name: np.array([t.error_nT[name] for t in trials]) for name in trials[0].error_nT}
    joint = error.pop(JOINT)
    alone = {name: error.pop(name) for name in ALONE}
    return [
        PaperRow(
            "joint correction against one alone, error of the field",
            "correction of one, as if the other were absent, is coarse (no number)",
            f"jointly {spread_text(joint)} nT; {_listed(alone)}",
            claim(
                all(np.quantile(joint, 0.95) < np.quantile(values, 0.05) for values in alone.values()),
                "95 % of the joint below 5 % of each alone",
                "claimed without a number: every seed must show it",
            ),
            "rms length over the stops",
        ),
        PaperRow(
            "joint correction against both corrections put together, error of the field",
            "has advantages over independent corrections (no number)",
            f"jointly {spread_text(joint)} nT; {_listed(error)}",
            incomparable("the paper compares with no figure and does not say how the two are put together"),
            "both, each found as if the other were absent, miss only products of two direction cosines, less than the "
            "noise here; one after the other misses nothing, because no tilt changes the total",
        ),
    ]


def _listed(error_nT: dict[str, Array]) -> str:
    return "; ".join(f"{name} {spread_text(values)}" for name, values in error_nT.items())


def _weakest(trials: list[ZhouTrial], state: State) -> PaperRow:
    limit = bound(state)
    worst = float(np.mean([t.weakest["weakest_std"] for t in trials]))
    condition = float(np.mean([t.weakest["condition_number"] for t in trials]))
    good = sum(t.status == "ok" for t in trials)
    return PaperRow(
        "what a turn about the vertical alone can tell",
        "not discussed",
        f"all five; condition number {condition:.1f}; worst: b1, {figure(worst, 2)} per {NOISE_NT:g} nT",
        incomparable("the paper does not ask what a turn can tell"),
        "c1, c2 from the first harmonic of z (horizontal field H); a1 + c1 and b2 + c2 from the first harmonic of the "
        "total (H V / F); b1 from its second harmonic (H^2 / 2 F). At the magnetic equator (V = 0) a1 and b2 are lost, "
        f"at the pole (H = 0) all five. b1 is {limit[1] / limit[0]:.1f} times less certain than a1, so the printed b1, "
        f"{PRINTED[1]:g}, is {PRINTED[1] / limit[1]:.1f} standard deviations at {NOISE_NT:g} nT; {good} of "
        f"{len(trials)} fits report ok",
    )


def _offset(clean: list[ZhouTrial], shifted: list[ZhouTrial], state: State) -> PaperRow:
    moved = np.mean([t.found for t in shifted], axis=0) - np.mean([t.found for t in clean], axis=0)
    expected = OFFSET_NT / state.field_enu_nT[2]
    return PaperRow(
        f"a sensor offset of {OFFSET_NT:g} nT in x, which the model leaves out",
        "assumed absent",
        f"a1 moves by {figure(moved[0], 2)}",
        incomparable("the paper assumes no offset"),
        f"a1 moves by offset / V = {figure(expected, 2)}, the others by at most "
        f"{figure(np.abs(moved[1:]).max(), 1)}: from a turn about the vertical an offset in x "
        "cannot be distinguished from a1, nor one in y from b2. The printed "
        f"a1 could be the effect of {abs(PRINTED[0] * state.field_enu_nT[2]):.0f} nT",
    )
