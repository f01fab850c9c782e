"""The diagnosis of several recordings: each by itself, then all together."""

from __future__ import annotations

import itertools
from collections.abc import Callable, Sequence
from dataclasses import replace

import numpy as np

from calib.numerics.threads import one_thread
from diagnosis.evidence.localise import Share
from diagnosis.policy import Policy
from diagnosis.problem.linear import LinearProblem
from diagnosis.repair.new_model import patched
from diagnosis.several.common_effects import Common, not_borne_out
from diagnosis.several.result import PooledDiagnosis
from diagnosis.several.selection import PooledRecording, select_together
from diagnosis.several.sentence import advice_together, sentence_together
from diagnosis.several.verdict_rules import Pool, PooledVerdict
from diagnosis.workflow import examined, told
from recordings import Recording
from scenarios.errors import InputError
from sim.scenario import Model

Progress = Callable[[str], object]


@one_thread()
def diagnose_together(
    names: Sequence[str],
    problems: Sequence[LinearProblem],
    model: Model,
    *,
    without: frozenset[str] = frozenset(),
    say: Progress = lambda what: None,
) -> PooledDiagnosis:
    """What n recordings of one instrument, posed with the same model, say together.

    An effect is believed where the coefficients that the other recordings give explain each, in nats over all of them
    (`accepted_together`, `coloured_nats` beside a coloured rest); it is transferred where the coefficients agree.

    Raises InputError for fewer than two recordings, and for the same samples twice.
    """
    if len(problems) < 2:
        raise InputError("a single recording has nothing to be held against", where="recordings", do="give two or more")
    for (name, one), (other, again) in itertools.combinations(zip(names, problems, strict=True), 2):
        check_apart(one.recording, again.recording, f"{name}, {other}")
    seen = []
    for name, problem in zip(names, problems, strict=True):
        seen.append(examined(problem, model, without, lambda what, name=name: say(f"{name}: {what}")))  # type: ignore[misc]
    members = [PooledRecording.of(one) for one in seen]
    chosen, alone = select_together(members, say)
    say("the simulator with the new models")
    lot = Pool(members, chosen)
    return _told(tuple(names), model, lot, [not_borne_out(one, lot.problems) for one in alone])


def check_apart(one: Recording, other: Recording, where: str) -> None:
    """InputError where two recordings are one: what it holds would be borne out by itself."""
    if np.array_equal(one.mag_nT, other.mag_nT):
        raise InputError("the field is the same in every sample", where=where, do="give recordings of different times")


def _told(names: tuple[str, ...], model: Model, lot: Pool, alone: Sequence[Common]) -> PooledDiagnosis:
    """The lot's diagnosis of what is believed, in words and with the new model."""
    judged = PooledVerdict.of(lot)
    each = tuple(told(one.seen) for one in lot.members)
    common, problems = judged.common, lot.problems
    found = PooledDiagnosis(
        names=names,
        each=each,
        verdict=judged.verdict,
        sentence="",
        common=common,
        single=tuple(alone),
        gap=judged.gap,
        gaps=judged.gaps,
        where=mean_shares([one.where for one in judged.cases], problems[0].policy),
        left=judged.left(names),
        advice=(),
        model=patched(model, [one.named for one in common], problems[0]),
        before_nT=tuple(one * problem.sigma_nT for one, problem in zip(judged.before, problems, strict=True)),
        after_nT=tuple(one * problem.sigma_nT for one, problem in zip(judged.after, problems, strict=True)),
    )
    return replace(found, sentence=sentence_together(found), advice=advice_together(found))


def mean_shares(several: Sequence[Sequence[Share]], policy: Policy) -> tuple[Share, ...]:
    """Channels by their mean share over the recordings."""
    shares: dict[str, list[Share]] = {}
    for one in (one for each in several for one in each):
        shares.setdefault(one.channel, []).append(one)
    mean = [Share(name, some[0].frame, sum(s.share for s in some) / len(several)) for name, some in shares.items()]
    return tuple(sorted(mean, key=lambda one: -one.share))[: policy.most_channels]
