"""The diagnosis from a recording and a model to a verdict, a new model and the gap before and after."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from scenarios.spec import Model
from sim.dataset import Recording
from sim.effects import BY_NAME
from sim.effects.base import Effect
from sim.state import Array
from validation.diagnosis.decision.select import Found, Selection, base_changes, select, unseen
from validation.diagnosis.decision.verdict import HALF, advice_for, sentence_for, verdict_of
from validation.diagnosis.evidence.compare import THRESHOLD, Ground
from validation.diagnosis.evidence.direct import direct_evidence, louder
from validation.diagnosis.evidence.localise import localise
from validation.diagnosis.evidence.noise import Noise, along_field, slow_noise, white_score
from validation.diagnosis.evidence.problem import Problem, posed
from validation.diagnosis.repair.model import patched
from validation.diagnosis.repair.patch import predict, refined, unexplained
from validation.diagnosis.result import Diagnosis, Gap, Named, Verdict

Progress = Callable[[str], object]
Where = tuple[tuple[str, str, float], ...]
MIMIC_LEFT, STILL, PATCHWORK = 0.2, 0.2, 0.9
"""Part of the gap that a form error may leave; part of a channel's share of the gap that it keeps of what is left;
least that several effects must explain."""
FORM_NOISE = 0.25
"""Part of the first effect's size below which a slow noise beside it is its form."""
HARDLY = 0.1
"""Excess of the residual's power over the noise's, below which a share of it says nothing."""
BESIDE_TIME = 0.1
"""Share of a gap that goes with a channel beyond what goes with time, above which it is no noise."""


def diagnose(
    recording: Recording,
    model: Model,
    *,
    field_enu_nT: Array | None = None,
    strength_nT: float | None = None,
    fitted_base: bool = False,
    without: frozenset[str] = frozenset(),
    say: Progress = lambda what: None,
) -> Diagnosis:
    """Where a recording and a model disagree, what is missing, and the model with it.

    field_enu_nT, strength_nT : the reference, where the model does not state it. fitted_base : the model's iron is not
    known, so that a difference of the base is no finding. without : effects left out of the library.

    Raises InputError as `validation.diagnosis.evidence.problem.pose` does, and for a bad effect table of the model.
    """
    say("direct evidence")
    whole = posed(recording, model, field_enu_nT, strength_nT)
    direct = direct_evidence(whole, without)
    problem = whole
    for one in direct:
        problem = problem.without(one.samples)
    selection = select(problem, without, say)
    noise = _noise(selection)
    found, base = _believed(selection, noise, fitted_base, without)
    say("the simulator with the new model")
    held_out = _refined(problem, found, base, fitted_base)
    seen = [Named(one.effect, (), "direct", None, 0.0) for one in direct]
    named = [*held_out, *seen, *_noises(selection, noise, [*held_out, *seen], without)]
    before_nT, after_nT, gap = _gap(problem, selection, found, base, [one.effect for one in held_out])
    after = selection.after if found or not selection.found else selection.before
    where = localise(problem, before_nT / problem.sigma_nT)
    verdict = verdict_of(named, after.clean or noise is not None, gap)
    if _mimics(verdict, problem, where, after_nT, gap, named):
        verdict = "unknown"
    if verdict == "unknown":  # what explains little is no name
        named = seen
        after_nT, gap = before_nT, replace(gap, after_nT=gap.before_nT, after_sigma=gap.before_sigma)
    unseen_names, missing = _unseen(problem, named), _without_channels(problem)
    return Diagnosis(
        verdict=verdict, sentence=sentence_for(verdict, named, gap, where, after), named=tuple(named), where=where,
        gap=gap, not_observable=(*unseen_names, *missing),
        advice=advice_for(verdict, named, unseen_names, missing, problem, where, _turning(problem, before_nT)),
        ranking=tuple((e.name, e.D, e.strength) for e in selection.first_ranking), before=selection.before,
        after=after, model=patched(model, named, problem, fitted_base), problem=problem, before_nT=before_nT,
        after_nT=after_nT,
    )  # fmt: skip


def _believed(
    selection: Selection, noise: tuple[Noise, bool] | None, fitted_base: bool, without: frozenset[str]
) -> tuple[tuple[Found, ...], tuple[Found, ...]]:
    """The effects found, and the changes of the base, that noise and what is left speak for."""
    if noise is None and not selection.after.clean and _explained(selection) < HALF:
        return (), ()
    found = () if noise is not None and noise[1] else selection.found
    base = () if fitted_base else base_changes(selection, without)
    if noise is not None:  # a slow wander moves the mean: no change of a constant
        base = tuple(f for f in base if f.name not in ("hard_iron", "sensor_offset"))
    return found, base


def _refined(problem: Problem, found: Sequence[Found], base: Sequence[Found], fitted_base: bool) -> list[Named]:
    """Effects and changes of the base with their parameters refined through the simulator's chain."""
    everything = np.ones(len(problem.recording), bool)
    V = found[0].evidence.V if found else 1.0
    fine = refined(problem, _made(found, base), everything, V, refit=fitted_base)
    return [
        Named(effect, f.alternatives, "base" if f in base else "held-out", f.evidence.D, f.evidence.strength, spread)
        for effect, spread, f in zip(fine.effects, fine.spread, (*found, *base), strict=True)
    ]


def _made(found: Sequence[Found], base: Sequence[Found]) -> list[Effect]:
    return [f.evidence.candidate.made(f.evidence.coefficients) for f in (*found, *base)]


def _noises(
    selection: Selection, noise: tuple[Noise, bool] | None, others: Sequence[Named], without: frozenset[str]
) -> list[Named]:
    """Slow noise, or more white noise than the model has."""
    if noise is None:
        effects = [one.effect for one in others]
        noisier = louder(selection.end.problem, selection.end.residual(), effects, without)
        return [] if noisier is None else [Named(noisier, (), "spectrum", None, 0.0)]
    one = noise[0]
    slow = tuple(e.name for e in selection.first_ranking if e.D > THRESHOLD)[:3] if not one.told else ()
    return [Named(one.effect, (*one.alternatives, *slow), "spectrum", one.gain, 0.0)]


def _unseen(problem: Problem, named: Sequence[Named]) -> tuple[str, ...]:
    """Effects that look like iron on this motion, but those that were found nevertheless."""
    names = {one.name for one in named}
    return tuple(name for name in unseen(problem) if name not in names) if problem.mode == "vector" else ()


def _explained(selection: Selection) -> float:
    """Share of the gap that the found effects explain, on the data that they were fitted to; 1 if it is hardly one."""
    before, after = (float((ground.residual() ** 2).mean()) - 1 for ground in (selection.start, selection.end))
    return (before - after) / before if before > HARDLY else 1.0


def _noise(selection: Selection) -> tuple[Noise, bool] | None:
    """Slow noise: alone (True), where it explains the gap as well as the found effects do, else in what they leave."""
    if selection.after.clean and not selection.found:
        return None
    problem, left = selection.end.problem, selection.end.residual()
    alone = _wander(problem, selection.start.residual())
    beside = _wander(problem, left) if selection.found and not selection.after.clean else None
    score = white_score(problem, left)
    price = selection.end.inside.shape[2] + THRESHOLD
    if beside is not None and beside.fits and beside.score > score:
        # The best of many slow courses takes more from a noise than its columns would by chance.
        score, price = beside.score, 2 * (selection.end.inside.shape[2] + THRESHOLD * len(selection.found))
    if alone is not None and alone.fits and (not selection.found or score - price < alone.score):
        return alone, True
    excess = float(np.sqrt(max((left**2).mean() - 1, 0.0)))
    form = FORM_NOISE * selection.found[0].evidence.strength if selection.found else 0.0
    if beside is None or not (beside.fits and beside.told) or excess < form:
        return None
    return beside, False


def _wander(problem: Problem, residual: Array) -> Noise | None:
    """Slow noise in a residual, unless that goes with a channel more than with time."""
    shares = {channel: share for channel, _, share in localise(problem, residual)}
    if max(shares.values(), default=0.0) > shares.get("time_s", 0.0) + BESIDE_TIME:
        return None
    return slow_noise(problem, residual)


def _gap(
    problem: Problem, selection: Selection, found: Sequence[Found], base: Sequence[Found], effects: Sequence[Effect]
) -> tuple[Array, Array, Gap]:
    """What is left before and after (n, q) in nT, and rms on the segments that the first split holds out."""
    held = _held_samples(selection.end)
    train = ~held & (problem.usable > 0)
    test = held & (problem.usable > 0)
    if problem.mode == "vector":
        before = unexplained(problem, problem.predicted_nT, train)
        new = _made(found, base)
        trained = refined(problem, new, train).effects if new else ()
        after = unexplained(problem, predict(problem, trained), train)
    else:
        before, after = selection.start.residual(), selection.end.residual() if found else selection.start.residual()
    sigma = problem.sigma_nT

    def rms(left: Array) -> float:
        return float(np.sqrt((left[test] ** 2).mean()))

    gap = Gap(rms(before * sigma), rms(before), rms(after * sigma), rms(after))
    return before * sigma, after * sigma, gap


def _mimics(
    verdict: Verdict, problem: Problem, where: Where, after_nT: Array, gap: Gap, named: Sequence[Named]
) -> bool:
    """Whether the found effects only resemble the cause.

    They do where several explain the gap and yet not most of it, and where what is left, be it a slow noise, still goes
    with the channels that the gap goes with.
    """
    noisy = any(one.how == "spectrum" for one in named)
    several = sum(one.how == "held-out" for one in named) > 1
    if not (verdict == "partial" or (verdict == "composite" and noisy)) or gap.explained is None:
        return False
    if verdict == "partial" and several and gap.explained < PATCHWORK:
        return True
    if not where or gap.explained > 1 - MIMIC_LEFT**2:
        return False
    left = {name: share for name, _, share in localise(problem, after_nT / problem.sigma_nT)}
    first = where[0][2]
    goes_with = [name for name, _, score in where if score > first / 2 and left.get(name, 0.0) > STILL * score]
    return bool(set(goes_with) - {"time_s"} if noisy else goes_with)


def _held_samples(ground: Ground) -> NDArray[np.bool_]:
    cut = ground.cut
    held = np.repeat(cut.held(0), cut.length)
    return np.concatenate([held, np.zeros(len(ground.problem.recording) - len(held), bool)])


def _turning(problem: Problem, left_nT: Array) -> bool:
    """Whether the slow part of what is left has nothing along the field, as an error of the attitude has."""
    return problem.mode == "vector" and along_field(problem, left_nT / problem.sigma_nT) < 0.12


def _without_channels(problem: Problem) -> tuple[str, ...]:
    """Effects whose causes this recording does not hold."""
    blind = {"attitude", "position"} if problem.mode == "strength" else set()
    return tuple(
        f"{name} (no {', '.join(sorted((set(cls.needs) - problem.has) | (blind & set(cls.needs))))})"
        for name, cls in BY_NAME.items()
        if not set(cls.needs) <= problem.has - blind
    )
