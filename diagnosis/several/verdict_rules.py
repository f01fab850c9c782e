"""The verdict of several recordings: what each believes with the lot's effects in, as one case, then doubts."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from diagnosis.decision.belief import Belief, believed
from diagnosis.decision.selection import tests_beside
from diagnosis.decision.verdict_rules import VerdictInput, doubts_of, verdict_of
from diagnosis.decision.white_choice import Accepted
from diagnosis.evidence.baseline import Baseline
from diagnosis.evidence.held_out import judged_at
from diagnosis.evidence.localise import localise
from diagnosis.evidence.rising_spectrum import RisingSpectrum
from diagnosis.problem.linear import LinearProblem
from diagnosis.repair.named_effects import noise_of
from diagnosis.result import GapSize, How, Named, Transfer
from diagnosis.several.coefficients import foretold
from diagnosis.several.common_effects import Common, changes_of_iron, fitted_effect, seen_by_values
from diagnosis.several.selection import Chosen, PooledRecording
from diagnosis.several.transfer import There, TransferFinding
from diagnosis.verdict import Verdict
from scenarios.arrays import Array
from validation.signals.amplitude import rms


@dataclass(frozen=True)
class Pool:
    """The recordings with what they believe together."""

    members: Sequence[PooledRecording]
    chosen: Sequence[Chosen]

    @property
    def problems(self) -> list[LinearProblem]:
        """The recordings beside the model."""
        return [one.problem for one in self.members]

    @property
    def before(self) -> tuple[Array, ...]:
        """What the base leaves (n, q) in each, in units of the noise."""
        return tuple(one.seen.belief.selection.start.residual() for one in self.members)

    def belief(self, i: int) -> Belief:
        """What one recording believes with the lot's effects in."""
        member, found = self.members[i], list(self.members[i].events)
        ground = member.ground
        for one in self.chosen:
            joint = one.finding.joint
            if joint.asked[i] is None or one.finding.there[i] is There.ABSENT:
                continue
            evidence = judged_at(ground, [joint.candidate])
            if evidence is not None:
                found.append(Accepted(evidence, one.alternatives))
                ground = ground.beside(joint.candidate.columns(member.problem))
        selection = member.seen.belief.selection
        after = tests_beside(ground, [one.name for one in found]) if found else selection.before
        return believed(replace(selection, found=tuple(found), end=ground, after=after))

    def left(self, i: int) -> Array:
        """What the effects leave (n, q) in one recording with the coefficients that the others give.

        Where coefficients differ from recording to recording its own are fitted beside its iron.
        """
        member = self.members[i]
        target, inside = member.problem.target, [*member.seen.belief.selection.start.inside, *_events(member)]
        for one in self.chosen:
            finding = one.finding
            if finding.joint.asked[i] is None or finding.there[i] is There.ABSENT:
                continue
            columns = finding.joint.candidate.columns(member.problem)
            if finding.reach is Transfer.NOT_TRANSFERRED:
                inside.append(columns)
            else:
                target = target - columns @ _foretold(finding, i)
        return Baseline.of(replace(member.problem, target=target), inside).residual()


def _events(member: PooledRecording) -> list[Array]:
    return [one.columns(member.problem) for one in member.events]


def _foretold(finding: TransferFinding, i: int) -> Array:
    """Coefficients (k,) that the other recordings give."""
    there = [
        (j, one)
        for j, (one, says) in enumerate(zip(finding.joint.estimates, finding.there, strict=True))
        if one is not None and says is not There.ABSENT
    ]
    place = [j for j, _ in there].index(i)
    return np.asarray(foretold([estimate for _, estimate in there])[place])


@dataclass(frozen=True)
class PooledVerdict:
    """Verdict and names of a lot after every doubt, with the gaps (n, q) that they leave in units of the noise."""

    verdict: Verdict
    common: tuple[Common, ...]
    beliefs: tuple[Belief, ...]
    cases: tuple[VerdictInput, ...]
    doubts: tuple[tuple[str, ...], ...]
    gap: GapSize
    gaps: tuple[GapSize, ...]
    before: tuple[Array, ...]
    after: tuple[Array, ...]

    @classmethod
    def of(cls, lot: Pool) -> PooledVerdict:
        """The verdict of all recordings as of one case; names are doubted where half of them speak against."""
        beliefs = tuple(_borne_out(lot.belief(i)) for i in range(len(lot.members)))
        common = _common(lot, beliefs)
        cases = tuple(_case(lot, i, [one.named for one in common], belief) for i, belief in enumerate(beliefs))
        gaps = tuple(one.gap for one in cases)
        one = replace(cases[0], clean=_nothing_is_left(common, beliefs), gap=joined(gaps), where=())
        verdict = verdict_of(replace(one, rise=next(filter(None, (each.rise for each in cases)), None)))
        doubts = tuple((*doubts_of(case, verdict), *_explains_little(case)) for case in cases)
        found = cls(
            verdict, common, beliefs, cases, doubts, joined(gaps), gaps, lot.before, tuple(one.left for one in cases)
        )
        return found.undone() if found.doubted else found

    @property
    def doubted(self) -> bool:
        """Whether the names explain too little, or half of the recordings speak against them."""
        return self.verdict is Verdict.UNKNOWN or 2 * sum(map(bool, self.doubts)) >= len(self.doubts)

    def undone(self) -> PooledVerdict:
        """The same where the names are taken back: nothing is explained."""
        direct = tuple(one for one in self.common if one.named.how is How.DIRECT)
        gaps = tuple(_undone(one) for one in self.gaps)
        return replace(
            self, verdict=Verdict.UNKNOWN, common=direct, gap=_undone(self.gap), gaps=gaps, after=self.before
        )

    def left(self, names: Sequence[str]) -> tuple[str, ...]:
        """What is left in which recording, and what speaks against the names."""
        each = zip(names, self.beliefs, self.cases, self.doubts, strict=True)
        return tuple(
            f"{name}: {why}"
            for name, belief, case, doubts in each
            for why in (*belief.after.why, *([case.rise.words] if case.rise else []), *doubts)
        )


def _explains_little(case: VerdictInput) -> tuple[str, ...]:
    """Where something is left: whether the lot's names explain less than a name must."""
    explained = case.gap.explained
    if case.clean or explained is None or explained >= case.problem.policy.least_share or not case.found:
        return ()
    return (f"what the others give explains {100 * explained:.0f} % of its gap",)


def _case(lot: Pool, i: int, named: Sequence[Named], belief: Belief) -> VerdictInput:
    """One recording with the lot's names."""
    member, after = lot.members[i], lot.left(i)
    before = lot.before[i]
    use = member.problem.usable > 0
    gap = GapSize.of(before[use], after[use], member.problem.sigma_nT, member.problem.policy)
    where, rise = localise(member.problem, before), RisingSpectrum.of(member.problem, before, after)
    return VerdictInput(member.problem, tuple(named), belief.clean, gap, where, after, rise)


def _common(lot: Pool, beliefs: Sequence[Belief]) -> tuple[Common, ...]:
    """Effects, changes of the iron, noise and what the values show, that more than one recording bears out."""
    fitted = sorted(lot.chosen, key=lambda one: -one.strength)
    effects = [fitted_effect(one, lot.problems) for one in fitted]
    iron = changes_of_iron([one.iron for one in beliefs], lot.problems)
    direct = [[Named(d.effect, (), How.DIRECT, None, 0.0) for d in one.seen.direct] for one in lot.members]
    noise = [noise_of(belief, [one.named for one in (*effects, *iron)]) for belief in beliefs]
    values = seen_by_values([[*d, *n] for d, n in zip(direct, noise, strict=True)], lot.problems[0].policy)
    return (*effects, *iron, *(one for one in values if _is_the_sensors(one)))


def _nothing_is_left(common: Sequence[Common], beliefs: Sequence[Belief]) -> bool:
    """Whether every recording is clean; slow noise that none of the lot's names stands for is no reason for it."""
    return all(one.clean if common else one.after.clean for one in beliefs)


def _is_the_sensors(one: Common) -> bool:
    """Slow noise of the sensor is of one size in all recordings; what is of another in each comes from elsewhere."""
    slow = one.named.how is How.SPECTRUM and one.named.effect.traits.spectrum is not None
    return not slow or one.reach is Transfer.TRANSFERRED


def _borne_out(belief: Belief) -> Belief:
    """Slow noise whose nature is not told is none: a disturbance that goes with the motion is alike in every run."""
    open_ = belief.noise is not None and not belief.noise.identified
    return replace(belief, noise=None) if open_ else belief


def joined(gaps: Sequence[GapSize]) -> GapSize:
    """The size of several gaps as one, each recording counting as much as another; explained of those with a gap."""
    open_ = [g for g in gaps if g.explained is not None]
    excess = sum(g.before_sigma**2 - 1 for g in open_)
    explained = min(1.0, sum(g.before_sigma**2 - g.after_sigma**2 for g in open_) / excess) if open_ else None
    before_nT, before, after_nT, after = (
        rms(np.array([getattr(g, name) for g in gaps]))
        for name in ("before_nT", "before_sigma", "after_nT", "after_sigma")
    )
    return GapSize(before_nT, before, after_nT, after, explained)


def _undone(gap: GapSize) -> GapSize:
    explained = None if gap.explained is None else 0.0
    return GapSize(gap.before_nT, gap.before_sigma, gap.before_nT, gap.before_sigma, explained)
