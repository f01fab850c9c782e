"""[Li2017]: 21 parameters with eddy currents by a Kalman filter, a rescaled one, and a fuzzy adaptive one."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np

from calib.vector_model import VectorData
from sim.pool import each
from sim.state import Array
from validation.plots.style import Figure
from validation.reproduce import li2017_figures as figures
from validation.reproduce.base import Findings, Progress, Reproduction, Row, Verdict
from validation.reproduce.li2017_trials import (
    ANGLE_RATES_RAD_S,
    CALM,
    INTERVAL_S,
    LOUD,
    MOTIONS,
    SOURCES,
    Marquardt,
    Outcome,
    Survey,
    changing_noise,
    long_run,
    marquardt,
    motion,
    sensitivity,
    simulated,
    survey,
    trial,
)

SURVEYS = 5
"""Most seeds of the survey, whose simulation takes seconds."""
MARQUARDTS = 10
LONG = (50_000, 200_000)
ALL_MOTIONS = ((ANGLE_RATES_RAD_S, INTERVAL_S), *MOTIONS)
STATE_VARIANCES = (1e-10, 1e-9, 1e-8, 1e-7)
Task = tuple[str, Any]
Results = dict[str, list[Any]]
Trials = list[dict[str, Outcome]]


@dataclass(frozen=True)
class Li2017(Reproduction):
    """Table 1 and 2, figures 3 to 10 and 13 to 15."""

    key: ClassVar[str] = "Li2017"
    title: ClassVar[str] = "Component compensation: Kalman filter, rescaled and fuzzy adaptive, 21 parameters"

    def run(self, jobs: int = 1, progress: Progress = lambda done, total: None) -> Findings:
        tasks = self._tasks()
        done: dict[int, Any] = {}
        for index, result in each(_numbered, list(enumerate(tasks)), jobs):
            done[index[0]] = result
            progress(len(done), len(tasks))
        results: Results = {}
        for k, (kind, _) in enumerate(tasks):
            results.setdefault(kind, []).append(done[k])
        rows = (
            *_original(results),
            *_proposed(results["trial"]),
            _motions(results["motion"]),
            *_parts(results["trial"]),
            *_adaptation(results),
            *_survey(results),
            *_marquardt(results["marquardt"]),
        )
        return Findings(rows, _figures())

    def _tasks(self) -> list[Task]:
        surveys = range(min(self.seeds, SURVEYS))
        return [
            *(("long", n) for n in LONG),
            *(("motion", m) for m in ALL_MOTIONS),
            *(("changing", q) for q in STATE_VARIANCES),
            ("sensitivity", None),
            *(("trial", s) for s in range(self.seeds)),
            *(("survey", (s, ())) for s in surveys),
            *(("without", (s, SOURCES)) for s in surveys),
            *((name, (s, (name,))) for name in SOURCES for s in surveys[:1]),
            *(("marquardt", s) for s in range(min(self.seeds, MARQUARDTS))),
        ]


def _numbered(numbered: tuple[int, Task]) -> Any:
    kind, argument = numbered[1]
    if kind == "sensitivity":
        return sensitivity()
    works: dict[str, Callable[[Any], Any]] = {
        "long": long_run,
        "trial": trial,
        "marquardt": marquardt,
        "motion": motion,
        "changing": changing_noise,
    }
    return works.get(kind, survey)(argument)


def _spread(values: Sequence[float] | Array, unit: str, digits: int = 3) -> str:
    """Median and 5 to 95 % of one figure over the seeds."""
    low, middle, high = np.quantile(values, (0.05, 0.5, 0.95))
    return f"{middle:.{digits}g} {unit} ({low:.{digits}g} to {high:.{digits}g})"


def _errors(trials: Trials, name: str, part: slice = slice(None)) -> Array:
    """Absolute parameter errors (seeds, k), %."""
    return np.abs([t[name].state_error_pct[part] for t in trials])


def _limit(value: float, limit: float) -> Verdict:
    return "better" if value < 0.9 * limit else "holds" if value <= limit else "does not hold"


def _vector(values: Array) -> str:
    return ", ".join(f"{v:.4g}" for v in values)


def _original(results: Results) -> list[Row]:
    trials: Trials = results["trial"]
    T_p = np.mean([t["kf"].state_error_pct[:3] for t in trials], axis=0)
    mean = _errors(trials, "kf").mean(axis=1)
    A, B = (_errors(trials, "kf", part).max(axis=1) for part in (slice(3, 12), slice(12, 21)))
    total = np.array([t["kf"].total_nT for t in trials])
    component = np.mean([t["kf"].component_nT for t in trials], axis=0)
    stuck: Verdict = "holds" if (T_p < -95).all() else "does not hold"
    rows = [
        Row(
            "original filter: T_p error after 10,000 samples, x y z",
            "-99.988, -99.988, -99.988 %",
            ", ".join(f"{v:.3f}" for v in T_p) + " %",
            stuck,
            "P = 100 is 10 nT for T_p beside 4e5 nT for A: the rest lies in the scaling, not in the data",
        )
    ]
    for n, left in zip(LONG, results["long"], strict=True):
        slow: Verdict = "holds" if T_p.mean() < left.mean() < -50 else "does not hold"
        rows.append(
            Row(
                f"original filter: T_p error after {n:,} samples",
                "moves to the truth extremely slowly",
                f"{left.mean():.2f} % (mean of x y z, one seed)",
                slow,
            )
        )
    return [
        *rows,
        Row(
            "original filter: mean parameter error",
            "16.2206 %",
            _spread(mean, "%"),
            "holds" if 13 < np.median(mean) < 19 else "does not hold",
            "three of 21 at 100 % make 14.3 %",
        ),
        Row(
            "original filter: largest error of A, of B",
            "21.4 %, 3.85 %",
            f"{_spread(A, '%')}; {_spread(B, '%')}",
            "not comparable",
            "which parameters take up the missing T_p depends on the motion, not printed",
        ),
        Row(
            "original filter: total-field error",
            "175.75 nT",
            _spread(total, "nT rms"),
            "not comparable",
            "the paper's measure of error and its motion are not printed; ours: rms of the compensated field "
            "without noise, over the run",
        ),
        Row(
            "original filter: component errors x, y, z",
            "59.2, 110.2, 122.2 nT",
            _vector(component) + " nT rms",
            "holds" if 0.5 < component.mean() / 97.2 < 2 else "does not hold",
            "near |T_p| = 40, 100, 120 nT: T_p is what is missing",
        ),
    ]


def _proposed(trials: Trials) -> list[Row]:
    T_p, everything = _errors(trials, "both", slice(3)), _errors(trials, "both")
    A, B = (_errors(trials, "both", part).max(axis=1) for part in (slice(3, 12), slice(12, 21)))
    total = np.array([t["both"].total_nT for t in trials])
    component = np.array([t["both"].component_nT for t in trials])
    settled = np.array([t["both"].settled for t in trials])
    mean = everything.mean(axis=1)
    worst = component.max(axis=1)
    return [
        Row(
            "rescaled + fuzzy: T_p error x, y, z",
            "1.879, 1.325, 1.952 %",
            f"{_vector(np.median(T_p, axis=0))} % (medians)",
            _limit(float(np.median(T_p)), 1.72),
        ),
        Row("rescaled + fuzzy: largest error of A", "0.414 %", _spread(A, "%"), _limit(float(np.median(A)), 0.414)),
        Row("rescaled + fuzzy: largest error of B", "0.31 %", _spread(B, "%"), _limit(float(np.median(B)), 0.31)),
        Row(
            "rescaled + fuzzy: mean parameter error",
            "0.3734 %",
            _spread(mean, "%"),
            _limit(float(np.median(mean)), 0.4),
        ),
        Row(
            "rescaled + fuzzy: total-field error",
            "6.66 nT",
            _spread(total, "nT rms"),
            _limit(float(np.median(total)), 6.7),
            f"at or below in {100 * (total <= 6.7).mean():.0f} % of the seeds",
        ),
        Row(
            "rescaled + fuzzy: component errors x, y, z",
            "6.03, 1.72, 1.52 nT",
            f"{_vector(np.median(component, axis=0))} nT rms; largest axis {_spread(worst, 'nT')}",
            _limit(float(np.median(component, axis=0).max()), 6.1),
            f"judged by the worst axis of the medians; all three below 6.1 nT in {100 * (worst <= 6.1).mean():.0f} % "
            "of the seeds; the printed run has one bad axis too",
        ),
        Row(
            "rescaled + fuzzy: settles",
            "near sample 4,000",
            _spread(settled, "samples", 4),
            "not comparable",
            "every parameter within 20 % from there on; it follows from the motion and from that "
            "limit, neither of which is printed: see the next row",
        ),
    ]


def _motions(runs: list[tuple[float, float, list[int]]]) -> Row:
    text = "; ".join(
        f"{'/'.join(f'{r:g}' for r in rates)} rad/s every {interval:g} s: {T_p:.2f} %, {mean:.3g} %, settled {settled}"
        for (rates, interval), (T_p, mean, settled) in zip(ALL_MOTIONS, runs, strict=True)
    )
    good = sum(mean <= 0.4 for _, mean, _ in runs)
    return Row(
        "other motions: T_p error of the original, mean error of the proposed, settled within 20, 5, 2 %",
        "-99.988 %, 0.3734 %, near 4,000",
        text,
        "holds" if good == len(runs) else "does not hold",
        f"mean error at or below 0.4 % on {good} of {len(runs)} motions; the first, used throughout, was taken "
        "after trying all of these, for its T_p error and settling; one seed",
    )


def _parts(trials: Trials) -> list[Row]:
    alone, both = (_errors(trials, name).mean(axis=1) for name in ("rescaled", "both"))
    nT = np.array([t["kf+fuzzy"].state_error_pct[:3] for t in trials])
    difference = max(
        float(np.abs(t["rescaled"].state_error_pct - t[n].state_error_pct).max())
        for t in trials
        for n in ("both", "no floor")
    )
    ratio = [t["both"].ratio for t in trials]
    fallen = max(t["no floor"].noise_nT2 for t in trials)
    return [
        Row(
            "rescaling alone: mean parameter error",
            "(not separated)",
            _spread(alone, "%"),
            "not comparable",
            f"the whole improvement: with the fuzzy part {_spread(both, '%')}",
        ),
        Row(
            "fuzzy part alone (T_p in nT): T_p error",
            "(not separated)",
            f"{nT.mean():.3f} %",
            "not comparable",
            "no improvement over the original filter",
        ),
        Row(
            "what the fuzzy part adds under Q = 1e-5",
            "the adaptation reaches the optimal parameters",
            f"{difference:.1g} % largest change of any parameter",
            "does not hold",
            f"ROR stays at {_spread(ratio, '')}: H Q H^T of about 1e4 nT^2 rules P_r, so R only falls, to our floor "
            f"or without one to {fallen:.0e} nT^2, and nothing changes",
        ),
    ]


def _adaptation(results: Results) -> list[Row]:
    trials: Trials = results["trial"]
    fixed, fuzzy = (_errors(trials, name).mean(axis=1) for name in ("calm", "calm+fuzzy"))
    total = [np.array([t[name].total_nT for t in trials]) for name in ("calm", "calm+fuzzy")]
    ratio = [float(np.median([t[name].ratio for t in trials])) for name in ("calm", "calm+fuzzy")]
    noise = [t["calm+fuzzy"].noise_nT2 for t in trials]
    others = "; ".join(
        f"{q:g}: {a:.3g}, {b:.3g} nT" for q, (a, b) in zip(STATE_VARIANCES, results["changing"], strict=True)
    )
    same = max(float(np.abs(t["changing"].state_error_pct - t["changing+fuzzy"].state_error_pct).max()) for t in trials)
    table: dict[tuple[int, float], tuple[int, float]] = results["sensitivity"][0]
    helps: Verdict = "holds" if np.median(total[1]) < np.median(total[0]) else "does not hold"
    loud = f"Q = {CALM.state_variance:g}, noise {LOUD:g} times larger in the last third"
    return [
        Row(
            f"adapting to changing noise, {loud}",
            "strong adaptivity to time-varying noise",
            f"total-field error {_spread(total[1], 'nT')} against {_spread(total[0], 'nT')} with R fixed at 25 nT^2; "
            f"mean parameter error {_spread(fuzzy, '%')} against {_spread(fixed, '%')}",
            helps,
            f"ROR {ratio[1]:.2f} against {ratio[0]:.1f}; R ends at {_spread(noise, 'nT^2', 4)}, truth 2500; Q and the "
            f"place of the jump are chosen so that it matters; total-field error fixed, adapted by Q: {others}",
        ),
        Row(
            "the same noise under the paper's Q = 1e-5",
            "strong adaptivity to time-varying noise",
            f"{same:.1g} % largest change by the fuzzy part",
            "does not hold",
            "Q hides the measurement noise",
        ),
        Row(
            "window n and exponent b (neither printed), first case",
            "b > 1 faster but oscillating, b < 1 slow",
            "; ".join(f"n {n} b {b:g}: {delay} samples, {ripple:.2f}" for (n, b), (delay, ripple) in table.items()),
            "holds"
            if all(table[n, 2.0][0] <= table[n, 0.5][0] and table[n, 2.0][1] >= table[n, 0.5][1] for n, _ in table)
            else "does not hold",
            "samples until R is within a factor of two after the jump, and its ripple, std of ln R; one seed",
        ),
    ]


def _survey(results: Results) -> list[Row]:
    surveys: list[Survey] = results["survey"]
    without: list[Survey] = results["without"]

    def mean(of: list[Survey], name: str) -> Array:
        return np.asarray(np.mean([s.rms_nT[name] if name else s.raw_nT for s in of], axis=0))

    raw, kf, proposed, lm = (mean(surveys, name) for name in ("", "kalman", "kalman_fuzzy", "vector_lm"))
    one = {name: results[name][0].rms_nT for name in SOURCES}
    settled = {name: [s.settled[name] for s in surveys] for name in ("kalman", "kalman_fuzzy")}
    shares = "; ".join(
        f"without {n} {_vector(rms['kalman_fuzzy'])}, least squares {_vector(rms['vector_lm'])}"
        for n, rms in one.items()
    )
    return [
        Row(
            "quadrotor: raw component error x, y, z",
            "3660, 4813, 2793 nT",
            _vector(raw) + " nT rms",
            "not comparable",
            "scenario quad-comb, whose iron is chosen to give about these",
        ),
        Row(
            "quadrotor: original filter",
            "668, 998, 851 nT",
            _vector(kf) + " nT rms",
            "not comparable",
            "smaller because the scenario disturbs less than the paper's site, not because the filter is better",
        ),
        Row(
            "quadrotor: rescaled + fuzzy",
            "568, 845, 761 nT",
            _vector(proposed) + " nT rms",
            "not comparable",
            "as above; rescaling alone gives the same",
        ),
        Row(
            "quadrotor: order on every axis",
            "proposed below original below raw",
            "proposed / original " + _vector(proposed / kf) + "; original / raw " + _vector(kf / raw),
            "holds" if (proposed < kf).all() and (kf < raw).all() else "does not hold",
            "paper: 0.85, 0.85, 0.89",
        ),
        Row(
            "quadrotor: the four named error sources removed",
            "alignment, reference field, gradient, surroundings",
            f"rescaled + fuzzy {_vector(mean(without, 'kalman_fuzzy'))}, least squares of 21 parameters "
            f"{_vector(mean(without, 'vector_lm'))} against {_vector(lm)} nT rms with them",
            "holds" if (mean(without, "vector_lm") < lm).all() else "does not hold",
            f"one at a time: {shares}; at the scenario's sizes the alignment rules, the other three hardly show",
        ),
        Row(
            "quadrotor: iterations until A settles, original and proposed",
            "149 and 29",
            f"{_spread(settled['kalman'], '', 4)} and {_spread(settled['kalman_fuzzy'], '', 4)}",
            "holds" if np.median(settled["kalman_fuzzy"]) < 0.5 * np.median(settled["kalman"]) else "does not hold",
            "sample from which all of A stays within 0.05 of its last values; settling waits for the turns, which "
            "scaling does not change; the paper's sample rate and criterion are not printed",
        ),
    ]


def _marquardt(runs: list[Marquardt]) -> list[Row]:
    paper = "194,580, 80,290, 325,380 nT"
    medians = {name: np.median([r.rms_nT[name] for r in runs], axis=0) for name in runs[0].rms_nT}
    notes = {
        "vector, 200 spread": "no failure, from the start of table 1 and without any scaling",
        "total field, 200 spread": "the paper writes N equations for N points, N >= 21: the total field's, which say "
        "nothing of a rotation; the strength fits to a few nT all the same",
        "vector, 21 consecutive": "21 samples in a row do not excite 21 columns: the printed order of size; a likely "
        "cause found by trying, the paper does not say which samples it took",
        "total field, 21 consecutive": "both together: the printed order of size too; likely, not printed",
    }
    verdicts: dict[str, Verdict] = {"vector, 200 spread": "does not hold"}
    return [
        Row(
            f"Levenberg-Marquardt, {name} samples: component errors",
            paper,
            _vector(rms) + " nT rms (medians)",
            verdicts.get(name, "not comparable"),
            notes[name],
        )
        for name, rms in medians.items()
    ]


def _figures() -> dict[str, Callable[[], Figure]]:
    data: VectorData = simulated(0)
    return {
        "parameters": lambda: figures.parameters(data),
        "compensation": lambda: figures.compensation(data),
        "adaptation": figures.adaptation,
    }
