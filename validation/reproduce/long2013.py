"""[Long2013]: maximum-likelihood ellipsoid by Newton's method; field strength, roll and pitch before and after."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

import numpy as np
from numpy.typing import NDArray

from sim.pool import each
from validation.palette import LINES, RAW
from validation.plots.style import Figure
from validation.reproduce.base import Findings, Progress, Reproduction, Row, Verdict
from validation.reproduce.long2013_trials import STRENGTH_NT, Task, Trial, run

Array = NDArray[np.float64]
NOISE_NT = 100.0
NOISES_NT = (10.0, 30.0, NOISE_NT, 200.0, 300.0, 400.0, 500.0)
"""Noise is not printed: 100 nT, 0.2 % of the field, and a sweep around it that shows what the figures bear."""
LIMIT_SHARE, LIMIT_ROLL_DEG, LIMIT_PITCH_DEG = 0.02, 1.0, 2.2
RAW_ROLL_DEG, RAW_PITCH_DEG = 27.0, 13.0


@dataclass(frozen=True)
class Long2013(Reproduction):
    """The paper's simulation with its printed errors, and its rolling test on a simulated turntable."""

    key: ClassVar[str] = "Long2013"
    title: ClassVar[str] = "Ellipsoid calibration of a three-axis magnetometer by maximum likelihood"

    def run(self, jobs: int = 1, progress: Progress = lambda done, total: None) -> Findings:
        """Each noise and seed: calibrate on four turns of 360 samples, roll once on the turntable."""
        tasks = [Task(seed, noise) for noise in NOISES_NT for seed in range(self.seeds)]
        results: dict[Task, Trial] = {}
        for task, trial in each(run, tasks, jobs):
            results[task] = trial
            progress(len(results), len(tasks))
        by_noise = {noise: [results[Task(seed, noise)] for seed in range(self.seeds)] for noise in NOISES_NT}
        trials = by_noise[NOISE_NT]
        rows = (
            _strength(trials),
            _roll(trials),
            _pitch(trials),
            _raw(trials, 0),
            _raw(trials, 1),
            _borne(by_noise),
            _alignment(trials),
            _newton(trials),
            _two_step(by_noise),
            _roll_alone(trials),
        )
        return Findings(
            rows,
            {
                "strength": lambda: _strength_figure(trials[0]),
                "attitude": lambda: _attitude_figure(trials[0]),
                "noise": lambda: _noise_figure(by_noise),
            },
        )


def _worst(trials: list[Trial], errors: str, axis: int) -> Array:
    """Largest error of roll (0) or pitch (1) over the turn, degrees, a value a trial."""
    return np.array([np.abs(getattr(trial, errors)[:, axis]).max() for trial in trials])


def _text(values: Array, unit: str, digits: int = 2) -> str:
    return f"{np.median(values):.{digits}f} {unit} (worst of {len(values)}: {values.max():.{digits}f})"


def _judge(values: Array, limit: float) -> Verdict:
    """By the worst seed; never "better", since the figure goes with a noise that is ours."""
    return "holds" if values.max() <= limit else "does not hold"


def _strength(trials: list[Trial]) -> Row:
    share = np.array([trial.worst_share for trial in trials])
    low, high = (np.mean([f(t.before_nT) for t in trials]) / STRENGTH_NT for f in (np.min, np.max))
    return Row(
        f"largest deviation of the corrected field strength, four turns (noise {NOISE_NT:g} nT)",
        "within 2 %",
        _text(100 * share, "%"),
        _judge(share, LIMIT_SHARE),
        f"raw {low:.2f} to {high:.2f} of the field; {sum(t.status == 'ok' for t in trials)} of {len(trials)} fits are "
        f"ok. The noise is not printed, {NOISE_NT:g} nT is our choice: see what noise the figures bear. "
        "Hard iron and offset are printed in nG, 0.07 to 0.09 nT, which would be nothing: read as nT",
    )


def _roll(trials: list[Trial]) -> Row:
    worst = _worst(trials, "corrected_deg", 0)
    return Row(
        f"largest roll error after, yaw 90, pitch -33.1 degrees (noise {NOISE_NT:g} nT)",
        "1 degree",
        _text(worst, "degrees"),
        _judge(worst, LIMIT_ROLL_DEG),
        "known field and yaw, pitch from the x component, roll from the other two, each sample alone",
    )


def _pitch(trials: list[Trial]) -> Row:
    worst = _worst(trials, "corrected_deg", 1)
    return Row(
        f"largest pitch error after, the same (noise {NOISE_NT:g} nT)",
        "2.2 degrees",
        _text(worst, "degrees"),
        _judge(worst, LIMIT_PITCH_DEG),
        "the paper's is a measured turntable with errors of its own, which are not printed",
    )


def _raw(trials: list[Trial], axis: int) -> Row:
    name, paper = (("roll", RAW_ROLL_DEG), ("pitch", RAW_PITCH_DEG))[axis]
    worst = _worst(trials, "raw_deg", axis)
    return Row(
        f"largest {name} error before, the same",
        f"{paper:g} degrees",
        _text(worst, "degrees", 1),
        "not comparable",
        "ours with the errors of the paper's simulation; those of its turntable test are not printed",
    )


def _borne(by_noise: dict[float, list[Trial]]) -> Row:
    limits = (LIMIT_SHARE, LIMIT_ROLL_DEG, LIMIT_PITCH_DEG)
    borne = []
    for k, limit in enumerate(limits):
        good = [noise for noise, trials in by_noise.items() if np.median(_figures(trials)[k]) <= limit]
        borne.append(max(good, default=0.0))
    return Row(
        "largest noise at which the median seed keeps the printed figures",
        "not printed",
        f"2 %: {borne[0]:g} nT; roll 1 degree: {borne[1]:g} nT; pitch 2.2 degrees: {borne[2]:g} nT",
        "not comparable",
        f"of {', '.join(f'{noise:g}' for noise in by_noise)} nT. All three grow in proportion to the noise; with a "
        "perfect model they measure the noise, so the printed ones speak of noise and turntable, not of the method",
    )


def _figures(trials: list[Trial]) -> tuple[Array, Array, Array]:
    share = np.array([trial.worst_share for trial in trials])
    return share, _worst(trials, "corrected_deg", 0), _worst(trials, "corrected_deg", 1)


def _alignment(trials: list[Trial]) -> Row:
    roll, pitch = _worst(trials, "unaligned_deg", 0), _worst(trials, "unaligned_deg", 1)
    aligned = np.median(_worst(trials, "corrected_deg", 0))
    needed: Verdict = "holds" if np.median(roll) > 2 * aligned else "does not hold"
    return Row(
        "V_L is needed: roll and pitch error with eq. 11 made symmetric, without eq. 12's alignment",
        "claimed, no figure",
        f"roll {_text(roll, 'degrees')}, pitch {_text(pitch, 'degrees')}",
        needed,
        "C_k C_n C_s is not symmetric; its rotation is not in the field's strength. The alignment needs the "
        "attitude of the calibration turns, so the whole method is not attitude-free",
    )


def _newton(trials: list[Trial]) -> Row:
    steps = np.array([trial.iterations for trial in trials])
    verdict: Verdict = "holds" if steps.max() <= 10 else "does not hold"
    return Row(
        "Newton's method converges from the two-step solution",
        "claimed, no figure",
        f"{np.median(steps):.0f} gradients (most: {steps.max()})",
        verdict,
        "the cost of eq. 10 has its infimum, 0, at T = 0, b = infinity, which the paper does not mention; "
        "Newton from elsewhere can run there, so the start is part of the method",
    )


def _two_step(by_noise: dict[float, list[Trial]]) -> Row:
    ratios = {
        noise: _rms([t.offset_error_nT for t in trials]) / _rms([t.twostep_error_nT for t in trials])
        for noise, trials in by_noise.items()
    }
    trials = by_noise[NOISE_NT]
    ours, start = _rms([t.offset_error_nT for t in trials]), _rms([t.twostep_error_nT for t in trials])
    low, high = min(ratios.values()), max(ratios.values())
    verdict: Verdict = "holds" if high < 1.0 else "does not hold"
    return Row(
        "more accurate than two-step alone (rms hard-iron error, Newton over two-step)",
        "claimed, no figure",
        f"{ours:.1f} over {start:.1f} nT at {NOISE_NT:g} nT; ratio {low:.3f} to {high:.3f} over the noises",
        verdict,
        "eq. 10 counts all directions alike, though the noise of |T (m - b)| goes with the gain of S, "
        "which runs from 1.0 to 2.4 here; the bench's two-step weights by it and is iterated, "
        "the paper's is not said to be",
    )


def _rms(values: list[float]) -> float:
    return float(np.sqrt(np.mean(np.square(values))))


def _roll_alone(trials: list[Trial]) -> Row:
    told = sum(trial.roll_alone == "unobservable" for trial in trials)
    return Row(
        "calibrating from the turntable's roll alone",
        "not said from which motion the test was calibrated",
        f"reported unobservable in {told} of {len(trials)}",
        "not comparable",
        "measurements of a turn about one axis lie in a plane: nine parameters need more motion than that",
    )


def _strength_figure(trial: Trial) -> Figure:
    figure = Figure(figsize=(7.0, 4.6), layout="constrained")
    top, bottom = figure.subplots(2, 1, sharex=True)
    sample = np.arange(len(trial.after_nT))
    top.plot(sample, trial.before_nT, color=RAW, label="before")
    top.plot(sample, trial.after_nT, color=LINES[0], label="after")
    top.axhline(STRENGTH_NT, color="0.3", linestyle=":", label="Earth field")
    top.set(ylabel="field strength (nT)", title="Turns about roll, pitch and yaw, then all three together")
    top.set_ylim(top=1.25 * float(trial.before_nT.max()))
    top.legend(ncols=3, loc="upper right")
    bottom.plot(sample, 100 * (trial.after_nT / STRENGTH_NT - 1), color=LINES[0])
    for limit in (-100 * LIMIT_SHARE, 100 * LIMIT_SHARE):
        bottom.axhline(limit, color="0.3", linestyle=":")
    bottom.set(xlabel="sample (a degree each)", ylabel="deviation after (%)", title="After (dotted: the paper's 2 %)")
    return figure


def _attitude_figure(trial: Trial) -> Figure:
    figure = Figure(figsize=(7.0, 5.6), layout="constrained")
    grid = figure.subplots(2, 2, sharex=True)
    limits = (LIMIT_ROLL_DEG, LIMIT_PITCH_DEG)
    for row, (name, limit) in enumerate(zip(("roll", "pitch"), limits, strict=True)):
        grid[row, 0].plot(trial.raw_deg[:, row], color=RAW)
        grid[row, 0].set(ylabel=f"{name} error (degrees)", title=f"{name}, before".capitalize())
        grid[row, 1].plot(trial.corrected_deg[:, row], color=LINES[0], label="aligned (eq. 12)")
        grid[row, 1].plot(trial.unaligned_deg[:, row], color=LINES[1], label="symmetric, not aligned")
        for bound in (-limit, limit):
            grid[row, 1].axhline(bound, color="0.3", linestyle=":")
        grid[row, 1].set(title=f"{name}, after (dotted: the paper's)".capitalize())
    for axis in grid[1]:
        axis.set(xlabel="roll (degrees)")
    grid[0, 1].legend()
    return figure


def _noise_figure(by_noise: dict[float, list[Trial]]) -> Figure:
    figure = Figure(figsize=(7.0, 3.6), layout="constrained")
    axis = figure.subplots()
    noises = np.array(list(by_noise))
    figures = [_figures(trials) for trials in by_noise.values()]
    parts = zip(
        ("strength / 2 %", "roll / 1 degree", "pitch / 2.2 degrees"),
        (LIMIT_SHARE, LIMIT_ROLL_DEG, LIMIT_PITCH_DEG),
        strict=True,
    )
    for k, (label, limit) in enumerate(parts):
        values = np.array([f[k] for f in figures]) / limit
        axis.plot(noises, np.median(values, axis=1), marker="o", color=LINES[k], label=label)
        axis.fill_between(noises, *np.quantile(values, (0.05, 0.95), axis=1), color=LINES[k], alpha=0.2, linewidth=0)
    axis.axhline(1.0, color="0.3", linestyle=":")
    axis.set(
        xlabel="noise of a component (nT)",
        ylabel="largest error / printed figure",
        xscale="log",
        yscale="log",
        title="What the printed figures bear (median, 5 to 95 % of seeds)",
    )
    axis.legend()
    return figure
