"""[Zhang2018]: an AUV's spiral; ellipsoid fit, particle swarm, genetic algorithm and their hybrid."""

from __future__ import annotations

from collections import Counter
from dataclasses import dataclass
from typing import ClassVar

import numpy as np
from numpy.typing import NDArray

from calib import Reference
from sim.chain import Chain
from sim.dataset import Recording
from sim.pool import each
from validation.reproduce.base import Findings, Progress, Reproduction, Row, Verdict
from validation.reproduce.zhang2018_figures import (
    AFTER_NT,
    DRIFT_NT_H,
    PRINTED_F_NT,
    TOTAL_NT,
    convergence_figure,
    drift_figure,
    rms_nT,
    turn_figure,
)
from validation.reproduce.zhang2018_trials import (
    DRIFTS,
    FITS,
    LONG,
    METHODS,
    POSITIONS,
    SEED,
    SETTINGS,
    TURN_S,
    DriftTrial,
    Trial,
    drift_trial,
    effects,
    search_trial,
    spiral,
    strength_nT,
)

Array = NDArray[np.float64]
CLAIMED_ORDER = ("psoga", "ga", "pso")
MAIN, SHORT, LONGER = (SETTINGS[k].label for k in (0, 3, 4))


@dataclass(frozen=True)
class Zhang2018(Reproduction):
    """The spiral of the paper with the errors of the scenario `auv-dive`, calibrated by the paper's methods."""

    key: ClassVar[str] = "Zhang2018"
    title: ClassVar[str] = "In-situ calibration of a vector magnetometer on an AUV: ellipsoid, PSO, GA, PSOGA"

    def run(self, jobs: int = 1, progress: Progress = lambda done, total: None) -> Findings:
        """The level spiral under every setting, then the excited spiral under every drift."""
        seeds, total = range(self.seeds), 2 * self.seeds
        found: dict[int, Trial] = {}
        drifted: dict[int, DriftTrial] = {}
        for seed, trial in each(search_trial, seeds, jobs):
            found[seed] = trial
            progress(len(found), total)
        for seed, drift in each(drift_trial, seeds, jobs):
            drifted[seed] = drift
            progress(self.seeds + len(drifted), total)
        trials, drifts = [found[s] for s in seeds], [drifted[s] for s in seeds]
        rows = (
            _raw(trials),
            *(_after(trials, name) for name in METHODS),
            _positions(trials),
            _order(trials),
            _by_iteration(trials),
            _longer(trials),
            _reductions(),
            _table_signs(),
            *_convergence(trials),
            _accuracy(trials),
            _level(),
            *_ellipsoid(drifts),
        )
        return Findings(
            rows,
            {
                "convergence": lambda: convergence_figure(trials),
                "turn": lambda: turn_figure(trials),
                "drift": lambda: drift_figure(drifts),
            },
        )


def _spread(values: Array, digits: int = 1) -> str:
    low, middle, high = np.quantile(values, (0.05, 0.5, 0.95))
    return f"{middle:.{digits}f} ({low:.{digits}f} to {high:.{digits}f})"


def _raw(trials: list[Trial]) -> Row:
    size = np.abs([t.raw_nT for t in trials])
    low, high = float(np.median(size.min(axis=1))), float(np.median(size.max(axis=1)))
    close = abs(low / 96.1 - 1) < 0.1 and abs(high / 292.4 - 1) < 0.1
    return Row(
        "raw error of the total field along one turn, nT, 30 positions",
        "96.1 to 292.4",
        f"{low:.1f} to {high:.1f}",
        _holds(close),
        "by construction: the printed example errors are scaled and the hard iron chosen to give this range. "
        f"The catalogue's F is {strength_nT(spiral(False)):.0f} nT (IGRF at sea level), the paper's 36,141",
    )


def _after(trials: list[Trial], name: str) -> Row:
    size = np.abs([t.errors_nT[MAIN, name] for t in trials])
    paper, curves = AFTER_NT[name], rms_nT(trials, MAIN, name)
    level = float(np.sqrt(np.mean(paper**2)))
    passed = int(np.argmax(np.median(curves, axis=0) < level)) + 1
    low, high = float(np.median(size.min(axis=1))), float(np.median(size.max(axis=1)))
    return Row(
        f"error along the turn after {name} (100 individuals, 200 iterations), nT",
        f"{paper.min()} to {paper.max()}",
        f"{low:.1f} to {high:.1f}",
        "better" if high < paper.max() else "does not hold",
        f"bounds of 10 % and 1000 nT (the paper gives none). The paper's rms, {level:.0f} nT, is passed at "
        f"iteration {passed} of 200; rms over the record at the end {_spread(curves[:, -1])} nT, median (5 to "
        "95 % of seeds); noise 2 nT an axis",
    )


def _positions(trials: list[Trial]) -> Row:
    by = {name: np.abs([t.errors_nT[MAIN, name] for t in trials]) for name in METHODS}
    raw = np.abs([t.raw_nT for t in trials])
    share = float(np.mean((by["psoga"] < by["ga"]) & (by["ga"] < by["pso"]) & (by["pso"] < raw)))
    below = float(np.mean(np.max(list(by.values()), axis=0) < raw))
    return Row(
        "PSOGA < GA < PSO < raw at every printed position",
        f"{POSITIONS} of {POSITIONS}",
        f"{100 * share:.0f} % of positions",
        _holds(share > 0.95),
        f"all three are below the raw error at {100 * below:.0f} % of the positions; six orders by chance: 17 %",
    )


def _orders(trials: list[Trial], setting: str) -> Counter[tuple[str, ...]]:
    return Counter(tuple(sorted(METHODS, key=lambda name: float(t.rms_nT[setting, name][-1]))) for t in trials)


def _order(trials: list[Trial]) -> Row:
    parts = []
    for setting in SETTINGS:
        orders = _orders(trials, setting.label)
        usual, count = orders.most_common(1)[0]
        rms = ", ".join(f"{name} {np.median(rms_nT(trials, setting.label, name)[:, -1]):.3g}" for name in METHODS)
        parts.append(
            f"{setting.label}: claimed order in {100 * orders[CLAIMED_ORDER] / len(trials):.0f} % of seeds, "
            f"most often {' < '.join(usual)} ({100 * count / len(trials):.0f} %), median rms {rms} nT"
        )
    share = _orders(trials, MAIN)[CLAIMED_ORDER] / len(trials)
    return Row(
        "order of the rms over the record: PSOGA < GA < PSO",
        "in all six dives",
        f"in {100 * share:.0f} % of {len(trials)} seeds",
        _holds(share > 0.95),
        "; ".join(parts),
    )


def _by_iteration(trials: list[Trial]) -> Row:
    curves = {name: rms_nT(trials, MAIN, name) for name in METHODS}
    shares, parts = [], []
    for t in (10, 25, 50, 100, 200):
        now = {name: c[:, t - 1] for name, c in curves.items()}
        shares.append(float(np.mean((now["psoga"] < now["ga"]) & (now["ga"] < now["pso"]))))
        medians = ", ".join(f"{name} {np.median(v):.3g}" for name, v in now.items())
        parts.append(f"{t}: {100 * shares[-1]:.0f} % ({medians} nT)")
    return Row(
        "the same order where the search is stopped early",
        "after 50 and after 200 iterations",
        f"in at most {100 * max(shares):.0f} % of seeds",
        _holds(max(shares) > 0.95),
        "claimed order by iteration, with median rms: " + "; ".join(parts) + ". Errors of the paper's size "
        "belong to the first tens of iterations, where the GA leads; it is last at the end",
    )


def _longer(trials: list[Trial]) -> Row:
    rms = {name: rms_nT(trials, LONGER, name)[:, -1] for name in METHODS}
    middle = {name: float(np.median(v)) for name, v in rms.items()}
    return Row(
        f"the same after {LONG} iterations: three methods, one cost",
        "not tried",
        ", ".join(f"{name} {_spread(v)}" for name, v in rms.items()) + " nT",
        "not comparable",
        f"psoga / pso {middle['psoga'] / middle['pso']:.3f}, ga / pso {middle['ga'] / middle['pso']:.2f}: the "
        "cost is the same and so is its minimum. A difference is how far a search has got, which iterations, "
        "bounds, c1, c2 and the mutation decide; a mutation of fixed size keeps the GA off the minimum",
    )


def _reductions() -> Row:
    raw, best = np.abs(TOTAL_NT - PRINTED_F_NT), AFTER_NT["psoga"]
    at = 100 * (1 - best / raw)
    return Row(
        "reduction of the error by PSOGA, from the printed table",
        "89.7 %",
        f"{at[5]:.0f} % at position 6, {at[27]:.0f} % at position 28",
        "does not hold",
        f"the printed figure pairs the largest raw error ({raw.max():.1f}, position 6) with the smallest "
        f"corrected one ({best.min()}, position 28): {100 * (1 - best.min() / raw.max()):.1f} %. By position: "
        f"{at.min():.0f} to {at.max():.0f} %, mean {at.mean():.0f} %",
    )


def _table_signs() -> Row:
    raw = TOTAL_NT - PRINTED_F_NT
    jump = float(np.abs(np.diff(raw)).max())
    flips = int(np.count_nonzero(np.diff(np.sign(raw))))
    signed = np.sign(raw) * AFTER_NT["psoga"]
    ours = np.abs(np.diff(np.linalg.norm(_measured(0)[:POSITIONS], axis=1))).max()
    return Row(
        "the printed table as a calibration's residual",
        "|error| 30.5 to 57.8, never near zero",
        "not a minimum",
        "does not hold",
        f"the printed totals cross F {flips} times, by up to {jump:.0f} nT in 10 s, while |error| runs smoothly "
        f"(our largest step: {ours:.0f} nT). At a minimum of the cost the scale of R alone makes the mean "
        f"residual zero; with the raw errors' signs PSOGA's has a mean of {signed.mean():.0f} nT and a rms of "
        f"{np.sqrt(np.mean(signed**2)):.0f} nT",
    )


def _convergence(trials: list[Trial]) -> tuple[Row, ...]:
    curves = {name: rms_nT(trials, MAIN, name) for name in METHODS}
    short = {name: rms_nT(trials, SHORT, name) for name in METHODS}
    pso = np.median(curves["pso"], axis=0)
    half = np.median(short["pso"], axis=0)
    rises = np.mean(np.diff(curves["ga"], axis=1) > 0, axis=1)
    first = np.array([np.argmin([c[i, 0] for c in curves.values()]) == 2 for i in range(len(trials))])
    last = np.array([np.argmin([c[i, -1] for c in short.values()]) == 2 for i in range(len(trials))])
    smooth = np.mean(np.diff(short["psoga"], axis=1) > 0)
    return (
        Row(
            "PSO falls fast, then stalls (iterations 1 to 50)",
            "hardly changes late",
            f"rms {pso[0]:.0f}, {pso[9]:.0f}, {pso[49]:.0f}, {pso[199]:.1f} nT at 1, 10, 50, 200",
            _holds(pso[49] < 1.2 * pso[199]),
            "still falling at 50, when the inertia is 0.81: with c1 = c2 = 2 a swarm contracts only below 0.41. A run "
            f"of 50 in all falls to {half[-1]:.1f} nT, by a factor {half[24] / half[-1]:.1f} in its second half",
        ),
        Row(
            "GA rebounds at times",
            "seen",
            f"the best gets worse in {100 * rises.mean():.0f} % of the generations",
            _holds(rises.min() > 0),
            "no elite is kept, as the paper has it; the best also cross and mutate",
        ),
        Row(
            "PSOGA starts lowest",
            "lowest at iteration 1",
            f"lowest in {100 * first.mean():.0f} % of seeds",
            _holds(first.mean() > 0.95),
            "one in three by chance: all begin with the same random spread",
        ),
        Row(
            "PSOGA falls steadily and is lowest after 50 iterations",
            "lowest",
            f"lowest in {100 * last.mean():.0f} % of seeds",
            _holds(last.mean() > 0.95),
            f"never rises ({100 * smooth:.0f} % of steps): the best seen is kept. Runs of 50 iterations end at "
            + ", ".join(f"{name} {_spread(v[:, -1])}" for name, v in short.items())
            + " nT",
        ),
    )


def _accuracy(trials: list[Trial]) -> Row:
    parts = ", ".join(f"{name} {_spread(np.array([t.offset_nT[LONGER, name] for t in trials]), 0)}" for name in METHODS)
    return Row(
        "error of the hard iron behind residuals of a few nT",
        "not known",
        f"{parts} nT",
        "not comparable",
        f"after {LONG} iterations, bounds of 1000 nT an axis: level circles leave the vertical offset and the "
        "matrix free, so the error of the calibrated record, the paper's measure, says nothing of the hard iron",
    )


def _level() -> Row:
    recording, reference = Recording(spiral(False).time_s, _measured(0)), Reference(strength_nT(spiral(False)))
    status = FITS["whole"].fit(recording, reference).status
    return Row(
        "ellipsoid fit of the whole level spiral",
        "poor",
        status.kind,
        _holds(status.kind != "ok"),
        f"the cause is the motion before any drift: {status.reason}. In segments: "
        f"{FITS['segmented'].fit(recording, reference).status.kind}",
    )


def _measured(seed: int) -> Array:
    return Chain(effects(), SEED, seed).apply(spiral(False))[0]


def _ellipsoid(drifts: list[DriftTrial]) -> tuple[Row, ...]:
    rms = {name: np.array([d.rms_nT[name] for d in drifts]) for name in FITS}
    last = f"a drift of {DRIFTS[-1] * DRIFT_NT_H:.0f} nT/h"
    worse = np.mean(rms["whole"][:, -1] > 5 * rms["whole"][:, 0])
    pieces = [np.median([d.segments["segmented"][i] for d in drifts]) for i in range(len(DRIFTS))]
    return (
        Row(
            "ellipsoid fit of the whole record without drift, rms, nT",
            "not tried",
            _spread(rms["whole"][:, 0]),
            _holds(np.median(rms["whole"][:, 0]) < 3.0),
            "roll and pitch of 20 and 25 degrees commanded; noise 2 nT an axis",
        ),
        Row(
            "whole-record ellipsoid fit is poor because the hard iron drifts",
            "poor (figure)",
            f"rms {_spread(rms['whole'][:, -1])} nT under {last}",
            _holds(worse > 0.95),
            _courses(rms, 1),
        ),
        _better(
            rms,
            "segmented",
            "cuts found by the program",
            f"`ellipsoid_segmented`, which finds the cuts itself: {', '.join(f'{n:g}' for n in pieces)} segments "
            "(medians) at the four drifts. In-sample, as in the paper: see the error of the offset",
        ),
        _better(rms, "by turns", f"cut at each turn of {TURN_S:g} s", "every piece sees all headings"),
        _offsets(drifts),
    )


def _better(rms: dict[str, Array], name: str, label: str, note: str) -> Row:
    gain = np.mean(rms[name][:, -1] < rms["whole"][:, -1] / 2)
    return Row(
        f"segmented ellipsoid fit is clearly better: {label}",
        "clearly better (figure)",
        f"rms {_spread(rms[name][:, -1])} nT at the same drift",
        _holds(gain > 0.95),
        note,
    )


def _offsets(drifts: list[DriftTrial]) -> Row:
    error = {name: np.array([d.offset_nT[name] for d in drifts]) for name in FITS}
    ours = ", ".join(f"{name} {_spread(values[:, -1], 0)}" for name, values in error.items())
    return Row(
        "the same fits' error of the moving offset, rms over the record",
        "not known",
        f"{ours} nT",
        "not comparable",
        f"{_courses(error, 0)}. A short segment fits the strength and leaves the offset less "
        "certain, which the residual does not show",
    )


def _courses(values: dict[str, Array], digits: int) -> str:
    return "; ".join(
        f"{k * DRIFT_NT_H:.3g} nT/h: "
        + ", ".join(f"{name} {np.median(v[:, i]):.{digits}f}" for name, v in values.items())
        + " nT"
        for i, k in enumerate(DRIFTS)
    )


def _holds(claim: bool | np.bool) -> Verdict:
    return "holds" if claim else "does not hold"
