"""[Zhou2012]: five direction cosines from twelve stops about the vertical, by differential evolution."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import ClassVar

import numpy as np
from numpy.typing import NDArray

from calib import Reference
from calib.de_turntable import NAMES, DeTurntable, axes_matrix, derivatives
from scenarios.load import load
from sim.chain import Chain
from sim.dataset import Recording
from sim.effects.base import Effect
from sim.effects.drift import SensorOffset
from sim.effects.noise import WhiteNoise
from sim.effects.papers import zhou2012
from sim.field import earth_field_enu_nT
from sim.pool import each
from sim.state import State
from sim.streams import stream
from validation.plots.style import Figure
from validation.reproduce.base import Findings, Progress, Reproduction, Row, Verdict

Array = NDArray[np.float64]
PRINTED = (0.013572, 0.000115, -0.006312, -0.021201, -0.003657)
STOPS, STEP_RAD = 12, -np.radians(30.0)
NOISE_NT = 1.0
OFFSET_NT = 10.0
STABLE_AT = 100
SEED = 2012


@dataclass(frozen=True)
class Trial:
    """One seed: the five found (5,), the rms of objective after each iteration (nT), z before and after (12,), nT."""

    found: Array
    claimed: Array
    history: Array
    z_nT: Array
    flat_nT: Array
    weakest: dict[str, float]
    status: str


@dataclass(frozen=True)
class _Task:
    seed: int
    offset_nT: float = 0.0


def stops() -> State:
    """Twelve stops of 30 degrees clockwise of an ideal level sensor, in the field of the catalogue's scenario."""
    field = earth_field_enu_nT(load("turntable-twelve-stops").field)
    yaw = STEP_RAD * np.arange(STOPS)
    R_wb = np.zeros((STOPS, 3, 3))
    R_wb[:, 0, 0] = R_wb[:, 1, 1] = np.cos(yaw)
    R_wb[:, 1, 0], R_wb[:, 0, 1] = np.sin(yaw), -np.sin(yaw)
    R_wb[:, 2, 2] = 1.0
    still = np.zeros((STOPS, 3))
    return State(
        np.arange(STOPS, dtype=float),
        1.0,
        still,
        R_wb,
        still,
        field,
        np.einsum("nij,i->nj", R_wb, field),
        still,
        np.full(STOPS, 20.0),
        np.zeros((STOPS, 0)),
    )


def recording(state: State, seed: int, offset_nT: float = 0.0) -> Recording:
    """What the sensor of the printed values measures at the stops, with white noise and an offset in x."""
    added: tuple[Effect, ...] = (SensorOffset((offset_nT, 0.0, 0.0)), WhiteNoise((NOISE_NT, NOISE_NT, NOISE_NT)))
    effects = (*zhou2012(*PRINTED), *added)
    return Recording(state.time_s, Chain(effects, SEED, seed).apply(state)[0])


def _run(task: _Task) -> Trial:
    state = stops()
    measured = recording(state, task.seed, task.offset_nT)
    fit = DeTurntable().fit(measured, _reference(state), stream(SEED, task.seed, "search"))
    found = np.array([fit.parameters[name] for name in NAMES])
    assert fit.covariance is not None
    return Trial(
        found,
        np.sqrt(np.diag(fit.covariance)),
        np.array(fit.history),
        measured.mag_nT[:, 2],
        fit.apply(measured)[:, 2],
        {k: fit.parameters[k] for k in ("condition_number", "weakest_std")},
        fit.status.kind,
    )


def _reference(state: State) -> Reference:
    return Reference(float(np.linalg.norm(state.field_enu_nT)))


def bound(state: State) -> Array:
    """Cramer-Rao bound (5,) on the standard deviation, every azimuth and both parts of the field unknown.

    m_i = A (H cos p_i, H sin p_i, V): 36 measurements, unknown A's five, H, V and the twelve p_i.
    """
    A, h = axes_matrix(np.array(PRINTED)), state.field_nT
    level = h * [1.0, 1.0, 0.0]
    columns = [(h @ step.T).ravel() for step in derivatives(np.array(PRINTED))]
    columns += [(level @ A.T).ravel() / np.linalg.norm(level[0]), np.tile(A[:, 2], STOPS)]
    turned = np.cross([0.0, 0.0, 1.0], h) @ A.T / np.linalg.norm(h[0])
    for i in range(STOPS):
        columns.append((turned * (np.arange(STOPS) == i)[:, None]).ravel())
    J = np.array(columns).T / NOISE_NT
    scale = np.linalg.norm(J, axis=0)
    return np.asarray(np.sqrt(np.diag(np.linalg.inv((J / scale).T @ (J / scale)))) / scale)[:5]


@dataclass(frozen=True)
class Zhou2012(Reproduction):
    """The paper's five values as the truth of a simulated turntable run, found again by its own algorithm."""

    key: ClassVar[str] = "Zhou2012"
    title: ClassVar[str] = "Joint correction of non-orthogonality and non-levelness by differential evolution"

    def run(self, jobs: int = 1, progress: Progress = lambda done, total: None) -> Findings:
        """Twelve stops a seed, with fresh noise; then again with an offset that the model does not hold."""
        tasks = [_Task(seed, offset) for offset in (0.0, OFFSET_NT) for seed in range(self.seeds)]
        results: dict[_Task, Trial] = {}
        for task, trial in each(_run, tasks, jobs):
            results[task] = trial
            progress(len(results), len(tasks))
        trials = [results[task] for task in tasks]
        clean, shifted = trials[: self.seeds], trials[self.seeds :]
        state = stops()
        rows = (
            *_values(clean, bound(state), state),
            _stable(clean),
            _flat(clean),
            _weakest(clean, state),
            _offset(clean, shifted, state),
        )
        return Findings(
            rows,
            {
                "objective": lambda: _objective_figure(clean),
                "parameters": lambda: _course_figure(state),
                "z": lambda: _z_figure(clean[0]),
            },
        )


def _values(trials: list[Trial], limit: Array, state: State) -> tuple[Row, ...]:
    found = np.array([t.found for t in trials])
    error = np.sqrt(np.mean((found - PRINTED) ** 2, axis=0))
    level, up = np.hypot(*state.field_enu_nT[:2]), state.field_enu_nT[2]
    where = f"field {level:.0f} nT level, {up:.0f} nT up; noise {NOISE_NT:g} nT"
    own = np.mean([t.claimed for t in trials], axis=0)
    # the rms of n errors scatters by 1 / sqrt(2 n): three of that above the bound
    slack = 1.0 + 3.0 / np.sqrt(2 * len(trials))
    rows = []
    for k, name in enumerate(NAMES):
        verdict: Verdict = "holds" if error[k] <= slack * own[k] else "does not hold"
        note = (
            f"rms error {error[k]:.2e} over {len(trials)} seeds: {error[k] / own[k]:.2f} of what the noise does to "
            f"the minimum of this objective (Jacobian), {own[k]:.2e}; Cramer-Rao bound {limit[k]:.2e}"
        )
        if own[k] > 1.1 * limit[k]:
            note += (
                f". The objective gives away a factor {own[k] / limit[k]:.2f}: it weights z and the total as if "
                "their noises were independent, and they share the noise of z"
            )
        rows.append(
            Row(
                f"{name} found again ({where})",
                f"{PRINTED[k]:.6f}",
                f"{found[:, k].mean():.6f} ± {found[:, k].std():.1e}",
                verdict,
                note,
            )
        )
    return tuple(rows)


def _stable(trials: list[Trial]) -> Row:
    rms = np.array([t.history for t in trials])
    objective = rms**2
    share = objective[:, STABLE_AT - 1] / objective[:, 0]
    within = np.array([int(np.argmax(o <= 1.01 * o[-1])) + 1 for o in objective])
    holds: Verdict = "holds" if np.quantile(share, 0.95) < 0.01 else "does not hold"
    return Row(
        "objective against iterations (N 25, F_w 0.85, P_c 1, bounds ±0.2)",
        f"stable after about {STABLE_AT}",
        f"at {STABLE_AT}: {np.median(share):.1e} of the start (95 %: {np.quantile(share, 0.95):.1e})",
        holds,
        f"flat on the paper's linear axis; the noise floor (within 1 % of the end) is reached at iteration "
        f"{np.median(within):.0f} (5 to 95 %: {np.quantile(within, 0.05):.0f} to {np.quantile(within, 0.95):.0f})",
    )


def _flat(trials: list[Trial]) -> Row:
    before, after = np.ptp([t.z_nT for t in trials], axis=1), np.ptp([t.flat_nT for t in trials], axis=1)
    # twelve normal deviates range over 3.26 standard deviations, on average
    verdict: Verdict = "holds" if np.median(after) < 4.0 * NOISE_NT else "does not hold"
    return Row(
        "z output over the turn, largest less smallest",
        "varies before, flat after (figure, no number)",
        f"{np.median(before):.0f} nT before, {np.median(after):.1f} nT after (median)",
        verdict,
        f"noise of {NOISE_NT:g} nT alone gives 3.3 nT",
    )


def _weakest(trials: list[Trial], state: State) -> Row:
    limit = bound(state)
    worst = float(np.mean([t.weakest["weakest_std"] for t in trials]))
    condition = float(np.mean([t.weakest["condition_number"] for t in trials]))
    good = sum(t.status == "ok" for t in trials)
    return Row(
        "what a turn about the vertical alone can tell",
        "not discussed",
        f"all five; condition number {condition:.1f}; worst: b1, {worst:.1e} per {NOISE_NT:g} nT",
        "not comparable",
        "c1, c2 from the first harmonic of z (horizontal field H); a1 + c1 and b2 + c2 from the first harmonic of the "
        "total (H V / F); b1 from its second harmonic (H^2 / 2 F). At the magnetic equator (V = 0) a1 and b2 are lost, "
        f"at the pole (H = 0) all five. b1 is {limit[1] / limit[0]:.1f} times less certain than a1, so the printed b1, "
        f"{PRINTED[1]:g}, is {PRINTED[1] / limit[1]:.1f} standard deviations at {NOISE_NT:g} nT; {good} of "
        f"{len(trials)} fits report ok",
    )


def _offset(clean: list[Trial], shifted: list[Trial], state: State) -> Row:
    moved = np.mean([t.found for t in shifted], axis=0) - np.mean([t.found for t in clean], axis=0)
    expected = OFFSET_NT / state.field_enu_nT[2]
    return Row(
        f"a sensor offset of {OFFSET_NT:g} nT in x, which the model leaves out",
        "assumed absent",
        f"a1 moves by {moved[0]:.1e}",
        "not comparable",
        f"a1 moves by offset / V = {expected:.1e}, the others by at most {np.abs(moved[1:]).max():.0e}: from a turn "
        "about the vertical an offset in x cannot be told from a1, nor one in y from b2. The printed a1 could be the "
        f"work of {abs(PRINTED[0] * state.field_enu_nT[2]):.0f} nT",
    )


def _objective_figure(trials: list[Trial]) -> Figure:
    figure = Figure(figsize=(7.0, 3.6), layout="constrained")
    axis = figure.subplots()
    rms = np.array([t.history for t in trials])
    steps = np.arange(1, rms.shape[1] + 1)
    axis.fill_between(
        steps, *np.quantile(rms, (0.05, 0.95), axis=0), alpha=0.25, linewidth=0, label="5 to 95 % of seeds"
    )
    axis.plot(steps, np.median(rms, axis=0), label="median")
    axis.axvline(STABLE_AT, color="0.5", linestyle=":", label="paper: stable")
    axis.set(
        xlabel="iteration",
        ylabel="rms of the objective's terms (nT)",
        yscale="log",
        title="Objective against iterations",
    )
    axis.legend()
    return figure


def _course_figure(state: State) -> Figure:
    """The five against iterations, one seed: each length of run draws the same random numbers."""
    figure = Figure(figsize=(7.0, 3.6), layout="constrained")
    axis = figure.subplots()
    measured, reference = recording(state, 0), _reference(state)
    lengths = np.unique(np.geomspace(1, 500, 40).round().astype(int))
    fits = [
        replace(DeTurntable(), iterations=int(n)).fit(measured, reference, stream(SEED, 0, "search")) for n in lengths
    ]
    for k, name in enumerate(NAMES):
        line = axis.plot(lengths, [fit.parameters[name] for fit in fits], label=name)[0]
        axis.axhline(PRINTED[k], color=line.get_color(), linestyle=":", linewidth=0.8)
    axis.set(xlabel="iteration", ylabel="direction cosine", xscale="log", title="The five (dotted: the paper's values)")
    axis.legend(ncols=5)
    return figure


def _z_figure(trial: Trial) -> Figure:
    figure = Figure(figsize=(7.0, 3.2), layout="constrained")
    axis = figure.subplots()
    angle = 30.0 * np.arange(STOPS)
    curves: tuple[tuple[Array, str], ...] = ((trial.z_nT, "before"), (trial.flat_nT, "after"))
    for z, label in curves:
        axis.plot(angle, z - trial.flat_nT.mean(), marker="o", label=label)
    axis.set(xlabel="turn, clockwise (degrees)", ylabel="z less its mean after (nT)", title="z output over the turn")
    axis.legend()
    return figure
