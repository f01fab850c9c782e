"""One flight with too small a motor gain in the model, in white and in coloured noise: for `diagnosis-method.md`."""

from __future__ import annotations

from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.figure import Figure
from scipy.stats import chi2

import magbench
from diagnosis.evidence.baseline import Baseline
from diagnosis.evidence.candidate_test import CandidateFit, ColouredBaseline
from diagnosis.result import Diagnosis
from diagnosis.workflow import diagnose
from reports.palette import AFTER, BEFORE, RAW, SOFT
from reports.plots.style import panels
from reports.presentation.diagnosis import PresentedDiagnosis
from scenarios.arrays import Array
from sim.scenario import load

FLIGHT = Path(__file__).parent / "gallery" / "verdicts" / "flight.toml"
MOTION = ("phases.0.duration_s=400", "sampling.rate_hz=10")
HIDDEN = ("effects.motor_current.gain_nT_A=[4,-2,8]",)
SLOW = ("effects.flicker_noise.density_nT_sqrt_hz=[1.5,1.5,1.5]",)
"""Not in the model: the motor's field in both runs, flicker noise in the second."""
WIDTH_IN, LISTED, TESTED = 7.0, 9, 5
TICKS = (0, 8, 25, 100, 500)
WHITE, COLOURED = "white noise", "flicker noise"


@cache
def found() -> dict[str, Diagnosis]:
    """The diagnoses of both runs, by their noise."""
    model = load(str(FLIGHT), MOTION)
    runs = {WHITE: HIDDEN, COLOURED: HIDDEN + SLOW}
    return {
        noise: diagnose(magbench.simulate(str(FLIGHT), overrides=[*MOTION, *hidden])[0], model)
        for noise, hidden in runs.items()
    }


def draw_evidence() -> Figure:
    """Draw the candidates' nats and those needed, in white and in flicker noise."""
    figure, axes = panels(2.9, 1, 2, width_in=WIDTH_IN)
    for axis, (noise, diagnosis) in zip(axes, found().items(), strict=True):
        rows = diagnosis.ranking[:LISTED][::-1]
        names = {cause.name for cause in diagnosis.named}
        for y, one in enumerate(rows):
            axis.barh(y, one.nats, color=AFTER if one.name in names else RAW)
            axis.plot([one.needed] * 2, [y - 0.45, y + 0.45], color=BEFORE, linewidth=2.0)
        axis.set_yticks(range(len(rows)), [one.name for one in rows])
        _in_nats(axis)
        axis.set(title=noise, xlabel="evidence (nats); red: needed")
    return figure


def _in_nats(axis: Any) -> None:
    axis.set_xscale("symlog", linthresh=5)
    axis.set_xticks(TICKS, [str(tick) for tick in TICKS])
    axis.minorticks_off()
    axis.margins(x=0.08)


def draw_surrogates() -> Figure:
    """Draw the nats of candidates in flicker noise beside those of their own columns shifted in time."""
    diagnosis = found()[COLOURED]
    problem = diagnosis.problem
    baseline = ColouredBaseline.of(problem, Baseline.of(problem).accepted_columns)
    figure, axis = panels(1.7, width_in=WIDTH_IN)
    rows = diagnosis.ranking[:TESTED][::-1]
    for y, one in enumerate(rows):
        columns = baseline.rows.bin(one.evidence.candidate.columns(problem))
        fit: CandidateFit = baseline.fit_candidate(one.evidence, columns)
        shifted = baseline.surrogate_gains(fit)
        axis.scatter(shifted, np.full(len(shifted), y), s=14, color=RAW, label="shifted in time" if y == 0 else None)
        axis.scatter([fit.gain], [y], s=34, marker="D", color=AFTER, label="as recorded" if y == 0 else None)
    axis.set_yticks(range(len(rows)), [one.name for one in rows])
    _in_nats(axis)
    axis.set(xlabel="gain (nats) in flicker noise")
    axis.legend(loc="lower right")
    return figure


def draw_residual() -> Figure:
    """Draw the tests of the residual before and after: variance of means in white noise, spectrum in flicker noise."""
    figure, (means, spectrum) = panels(2.6, 1, 2, width_in=WIDTH_IN)
    _draw_means(means, found()[WHITE])
    _draw_spectrum(spectrum, found()[COLOURED])
    return figure


def _draw_means(axis: Any, diagnosis: Diagnosis) -> None:
    for tests, colour, label in ((diagnosis.before, BEFORE, "before"), (diagnosis.after, AFTER, "after")):
        axis.plot(list(tests.excess), list(tests.excess.values()), "o-", color=colour, label=label)
    lengths_s = np.array(list(diagnosis.before.excess))
    axis.plot(lengths_s, _most(diagnosis, lengths_s), "--", color=SOFT, label="fails above")
    axis.set_xscale("log")
    axis.set_xticks(lengths_s, [f"{length_s:g}" for length_s in lengths_s])
    axis.minorticks_off()
    axis.set(title=WHITE, xlabel="length of the means (s)", ylabel="variance over white noise's", ylim=(0, None))
    axis.legend()


def _most(diagnosis: Diagnosis, lengths_s: Array) -> Array:
    """Variance of means over that of white noise at which the test fails, for each length."""
    problem, policy = diagnosis.problem, diagnosis.problem.policy
    count = problem.target.shape[1] * np.floor(np.ptp(problem.state.time_s) / lengths_s)
    return np.asarray(chi2.isf(policy.test_alarm / len(policy.mean_lengths_s), count) / count)


def _draw_spectrum(axis: Any, diagnosis: Diagnosis) -> None:
    spectrum = PresentedDiagnosis.of(diagnosis).series.spectrum
    axis.loglog(spectrum.frequency_Hz, spectrum.before, color=BEFORE, label="before")
    axis.loglog(spectrum.frequency_Hz, spectrum.after, color=AFTER, label="after")
    axis.axhline(spectrum.level, color=SOFT, linestyle="--", label="noise of a sample")
    axis.set_yticks([2, 5, 10, 20, 40], ["2", "5", "10", "20", "40"])
    axis.minorticks_off()
    axis.set(title=COLOURED, xlabel="frequency (Hz)", ylabel="nT/√Hz")
    axis.legend()
