"""Rows of [Li2017]'s fuzzy adaptation (section 2.3): effect with the paper's settings, and with better suited ones."""

from __future__ import annotations

import numpy as np

from papers.base import PaperRow, spread_text
from papers.judgement import claim, incomparable
from papers.li2017.rows import T_P, Trials, errors_pct
from papers.li2017.trials import CALM, LOUD
from validation.text import figure

EFFECT_PCT, WHY_EFFECT = 0.01, "a hundredth of a per cent is a thirtieth of the printed mean error"
STATE_VARIANCES = (1e-10, 1e-9, 1e-8, 1e-7)
Table = dict[tuple[int, float], tuple[int, float]]


def fuzzy_rows(trials: Trials) -> list[PaperRow]:
    """Return the rows of rescaling alone, the fuzzy part alone, and the gain of the fuzzy part over rescaling."""
    alone, both = (errors_pct(trials, name).mean(axis=1) for name in ("rescaled", "both"))
    nT = np.array([t["kf+fuzzy"].state_error_pct[T_P] for t in trials])
    difference = max(_change(trials, "rescaled", other) for other in ("both", "no floor"))
    ratio = [t["both"].ratio for t in trials]
    fallen = max(t["no floor"].noise_nT2 for t in trials)
    return [
        PaperRow(
            "rescaling alone: mean parameter error",
            "(not separated)",
            spread_text(alone, "%"),
            incomparable("the paper does not separate the two parts"),
            f"the whole improvement: with the fuzzy part {spread_text(both, '%')}",
        ),
        PaperRow(
            "fuzzy part alone (T_p in nT): T_p error",
            "(not separated)",
            f"{nT.mean():.3f} %",
            incomparable("the paper does not separate the two parts"),
            "no improvement over the original filter",
        ),
        PaperRow(
            "what the fuzzy part adds under Q = 1e-5",
            "the adaptation reaches the optimal parameters",
            f"{figure(difference, 1)} % largest change of any parameter",
            claim(difference > EFFECT_PCT, f"a change above {EFFECT_PCT:g} %", WHY_EFFECT),
            f"ROR stays at {spread_text(ratio)}: H Q H^T of about 1e4 nT^2 rules P_r, so R only falls, to our floor "
            f"or without one to {figure(fallen, 1)} nT^2, and nothing changes",
        ),
    ]


def _change(trials: Trials, one: str, other: str) -> float:
    """Return the largest change of a parameter between two filters, %."""
    return max(float(np.abs(t[one].state_error_pct - t[other].state_error_pct).max()) for t in trials)


def exponent_row(changes: list[float]) -> PaperRow:
    """Return the row on which exponent b is the ordinary filter; changes: of R's logarithm at b = 0 and b = 1."""
    zero, one = changes
    return PaperRow(
        "the exponent b that leaves the ordinary filter",
        "b = 1",
        f"largest change of ln R: {figure(zero, 1)} at b = 0, {figure(one, 2)} at b = 1",
        claim(one == 0.0, "R unchanged", "the ordinary filter has a constant R"),
        "R_k = s_k^b R_k-1: b = 0 makes every factor 1 and leaves the ordinary filter, b = 1 adapts with the plain s_k",
    )


def adaptation_rows(trials: Trials, changing: list[tuple[float, float]], table: Table) -> list[PaperRow]:
    """Return the rows on noise that changes during the run, with a small Q and the paper's; window and exponent."""
    return [
        _small_state_noise(trials, changing),
        PaperRow(
            "the same noise under the paper's Q = 1e-5",
            "strong adaptivity to time-varying noise",
            f"{figure(_change(trials, 'changing', 'changing+fuzzy'), 1)} % largest change by the fuzzy part",
            claim(_change(trials, "changing", "changing+fuzzy") > EFFECT_PCT, f"above {EFFECT_PCT:g} %", WHY_EFFECT),
            "Q hides the measurement noise",
        ),
        PaperRow(
            "window n and exponent b (neither printed), first case",
            "b > 1 faster but oscillating, b < 1 slow",
            "; ".join(f"n {n} b {b:g}: {delay} samples, {ripple:.2f}" for (n, b), (delay, ripple) in table.items()),
            claim(
                all(table[n, 2.0][0] <= table[n, 0.5][0] and table[n, 2.0][1] >= table[n, 0.5][1] for n, _ in table),
                "the order of b = 2 and b = 0.5, for every window",
                "faster and slower have no number",
            ),
            "samples until R is within a factor of two after the jump, and its ripple, std of ln R; one seed",
        ),
    ]


def _small_state_noise(trials: Trials, changing: list[tuple[float, float]]) -> PaperRow:
    fixed, fuzzy = (errors_pct(trials, name).mean(axis=1) for name in ("calm", "calm+fuzzy"))
    total, total_fuzzy = (np.array([t[name].total_nT for t in trials]) for name in ("calm", "calm+fuzzy"))
    ratio, ratio_fuzzy = (float(np.median([t[name].ratio for t in trials])) for name in ("calm", "calm+fuzzy"))
    noise = [t["calm+fuzzy"].noise_nT2 for t in trials]
    others = "; ".join(
        f"{q:g}: {figure(a)}, {figure(b)} nT" for q, (a, b) in zip(STATE_VARIANCES, changing, strict=True)
    )
    return PaperRow(
        f"adapting to changing noise, Q = {CALM.state_variance:g}, noise {LOUD:g} times larger in the last third",
        "strong adaptivity to time-varying noise",
        f"mean length of the error {spread_text(total_fuzzy, 'nT')} against {spread_text(total, 'nT')} with R fixed "
        f"at 25 nT^2; mean parameter error {spread_text(fuzzy, '%')} against {spread_text(fixed, '%')}",
        claim(np.median(total_fuzzy) < np.median(total), "median below that with R fixed", "strong has no number"),
        f"ROR {ratio_fuzzy:.2f} against {ratio:.1f}; R ends at {spread_text(noise, 'nT^2', significant=4)}, truth "
        f"2500; Q and the place of the jump are chosen so that it matters; the same fixed, adapted by Q: {others}",
    )
