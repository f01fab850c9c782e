"""The loop over several recordings: the effect that gains most in all of them together goes in, beside a rest each."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, replace

import numpy as np

from diagnosis.decision.selection import tests_beside
from diagnosis.decision.white_choice import Accepted, are_kin, simplest
from diagnosis.evidence.baseline import Baseline, added_share
from diagnosis.evidence.candidate_test import ColouredBaseline, gains_along_the_field
from diagnosis.evidence.held_out import Evidence
from diagnosis.evidence.hypothesis import informations
from diagnosis.evidence.noise_model import NoiseModel
from diagnosis.library.candidates import Candidate
from diagnosis.policy import Policy
from diagnosis.problem.linear import LinearProblem
from diagnosis.result import Transfer
from diagnosis.several.coefficients import CoefficientEstimate, left_out_gains
from diagnosis.several.look_alikes import Settings, explain_as_much, is_useless_beside, look_alikes
from diagnosis.several.pooled_test import CandidateInRecording, PooledCandidate, beside_own, columns_in, estimate
from diagnosis.several.transfer import There, TransferFinding, finding
from diagnosis.workflow import Examined
from scenarios.arrays import Array
from sim.effects import EFFECTS

Progress = Callable[[str], object]


@dataclass(frozen=True, eq=False)
class PooledRecording:
    """A recording of the lot: what its own diagnosis believes, its own events, and the ground with what is in."""

    seen: Examined
    events: tuple[Accepted, ...]
    start: Baseline
    ground: Baseline

    @classmethod
    def of(cls, seen: Examined) -> PooledRecording:
        """The recording with nothing in but its own events, which no other recording can show."""
        start = seen.belief.selection.start
        events = tuple(one for one in seen.belief.found if one.evidence.candidate.once)
        ground = start
        for one in events:
            ground = ground.beside(one.columns(start.problem))
        return cls(seen, events, start, ground)

    @property
    def problem(self) -> LinearProblem:
        """The recording beside the model."""
        return self.start.problem

    @property
    def named(self) -> list[Accepted]:
        """What its own diagnosis finds and another recording can show."""
        return [one for one in self.seen.belief.found if one not in self.events]

    @property
    def names(self) -> set[str]:
        """Of these, what they may be instead too."""
        return {name for one in self.named for name in (one.name, *one.alternatives)}

    def instead_of(self, one: PooledCandidate) -> list[Array]:
        """Columns (N, q, k) of what its own diagnosis finds, of another kin, and does not take for such an effect."""
        others = (own for own in self.named if one.name not in (own.name, *own.alternatives))
        return [own.columns(self.problem) for own in others if not are_kin(own.evidence, one)]

    def beside(self, candidate: Candidate) -> PooledRecording:
        """The same with a further effect in, where the recording holds its causes."""
        columns = columns_in(candidate, self.problem)
        return self if columns is None else replace(self, ground=self.ground.beside(columns))


@dataclass(frozen=True)
class Chosen:
    """An effect that the lot believes, and those that its recordings together do not tell from it."""

    finding: TransferFinding
    alternatives: tuple[str, ...]

    @property
    def name(self) -> str:
        """The effect's name."""
        return self.finding.joint.name

    @property
    def strength(self) -> float:
        """Rms over the recordings in which it is present, in units of the noise of each."""
        pairs = zip(self.finding.joint.asked, self.finding.there, strict=True)
        sizes = [one.strength for one, there in pairs if one is not None and there is There.PRESENT]
        return float(np.sqrt(np.mean(np.square(sizes or [one.strength for one in self.finding.joint.there]))))

    def alone(self, besides: Sequence[ColouredBaseline]) -> Chosen:
        """The same as if nothing else were in."""
        joint = self.finding.joint
        asked = tuple(
            one and CandidateInRecording.of(one.candidate, one.problem, beside, one.columns)
            for one, beside in zip(joint.asked, besides, strict=True)
        )
        return replace(self, finding=replace(self.finding, joint=replace(joint, asked=asked)))


def select_together(members: Sequence[PooledRecording], say: Progress) -> tuple[list[Chosen], list[TransferFinding]]:
    """Effects that the recordings together bear out, and those that only one of them names."""
    policy, settings, chosen = members[0].problem.policy, _settings(members), list[Chosen]()
    first = [ColouredBaseline.of(one.problem, one.ground.inside) for one in members]
    while len(chosen) < policy.most_effects and not (chosen and _clean(members, [one.name for one in chosen])):
        say(f"all recordings together, round {len(chosen) + 1}")
        best = _best(members, settings, chosen)
        if best is None or _is_form(best, chosen, first, policy):
            break
        chosen.append(best)
        members = [one.beside(best.finding.joint.candidate) for one in members]
    return chosen, _not_borne_out(members, settings, chosen)


def _settings(members: Sequence[PooledRecording]) -> Settings:
    """The settings of every effect at which a recording alone accepts it, or where none does finds it best."""
    accepted, listed = Settings(), Settings()
    for member in members:
        _gather(accepted, (one.evidence for one in member.named))
        _gather(listed, (one.evidence for one in member.seen.belief.selection.judged))
    return listed | accepted


def _gather(found: Settings, several: Iterable[Evidence]) -> None:
    for one in several:
        if not one.candidate.once and one.candidate not in found.setdefault(one.name, []):
            found[one.name].append(one.candidate)


def _clean(members: Sequence[PooledRecording], names: Sequence[str]) -> bool:
    return all(tests_beside(one.ground, [*names, *(e.name for e in one.events)]).clean for one in members)


def _best(members: Sequence[PooledRecording], settings: Settings, chosen: Sequence[Chosen]) -> Chosen | None:
    """The first of the likeliest candidates that the recordings together bear out."""
    besides = [ColouredBaseline.of(one.problem, one.ground.inside) for one in members]
    tried = _tried(members, besides, settings, chosen)
    refused: list[PooledCandidate] = []
    for joint in sorted(tried, key=lambda one: -one.gain):
        if any(is_useless_beside(joint.columns, better) for better in refused):
            continue  # what a better one takes up does not stand in its place
        with_it = [one.beside(joint.candidate) for one in members]
        coloured = not _clean(with_it, [*(one.name for one in chosen), joint.name])
        found = _finding(joint, members, coloured=coloured)
        if _stands(found, members, with_it, coloured=coloured):
            named = _named(joint, found, tried, settings, members, coloured=coloured)
            if not _is_refused(named, members):
                return named
        if found.joint.asked == joint.asked:  # where one recording has another cause, that one may be what all have
            refused.append(joint)
    return None


def _stands(
    found: TransferFinding, members: Sequence[PooledRecording], with_it: Sequence[PooledRecording], *, coloured: bool
) -> bool:
    """Whether the recordings bear an effect out by more than chance, beside a coloured rest by enough of the gap."""
    if found.reach is None or found.nats <= _most_by_chance(found.joint):
        return False
    return not coloured or (_adds(found, members, with_it) and _along_the_field(found, members, with_it))


def _is_refused(one: Chosen, members: Sequence[PooledRecording]) -> bool:
    """Whether half of the recordings that could tell it by themselves do not, by one of a diagnosis' own doubts."""
    joint, names = one.finding.joint, {one.name, *one.alternatives}
    able = [member for i, member in enumerate(members) if joint.own(i) > joint.policy.coloured_nats]
    against = [member for member in able if not names & member.names]
    return bool(able) and 2 * len(against) >= len(able)


def _finding(joint: PooledCandidate, members: Sequence[PooledRecording], *, coloured: bool) -> TransferFinding:
    policy = members[0].problem.policy
    needed = policy.coloured_nats if coloured else policy.accepted_together(len(EFFECTS))
    pairs = zip(joint.asked, members, strict=True)
    asked = tuple(one and beside_own(one, member.instead_of(joint)) for one, member in pairs)
    named = [i for i, member in enumerate(members) if joint.name in (one.name for one in member.named)]
    return finding(replace(joint, asked=asked), needed, policy, named)


def _tried(
    members: Sequence[PooledRecording],
    besides: Sequence[ColouredBaseline],
    settings: Settings,
    chosen: Sequence[Chosen],
) -> list[PooledCandidate]:
    """The likeliest candidates beside the rests as they are, and what any recording alone names, with rests anew."""
    problems = [one.problem for one in members]
    flat = [one for several in settings.values() for one in several]
    rests = [one.poorer.rest for one in besides]
    likely = dict(zip(flat, _likely(flat, problems, besides, rests), strict=True))
    best = {name: max(several, key=lambda one: likely[one]) for name, several in settings.items()}
    order = sorted(best, key=lambda name: -likely[best[name]])[: problems[0].policy.tried_coloured]
    mine = {one.name for member in members for one in member.named} - {one.name for one in chosen}
    names = dict.fromkeys([*order, *mine])
    return [joint_of(best[name], settings[name], besides, problems) for name in names]


def joint_of(
    candidate: Candidate,
    settings: Sequence[Candidate],
    besides: Sequence[ColouredBaseline],
    problems: Sequence[LinearProblem],
) -> PooledCandidate:
    """A candidate at the best of its settings: the likeliest beside the rests that the given one leaves."""
    tried = max(one.tried for one in settings) * len(settings)
    joint = PooledCandidate.of(candidate, besides, problems, tried)
    if len(settings) == 1 or not joint.there:
        return joint
    rests = [
        beside.poorer.rest if one is None else one.hypothesis.rest
        for one, beside in zip(joint.asked, besides, strict=True)
    ]
    likely = _likely(settings, problems, besides, rests)
    best = max(settings, key=lambda one: likely[settings.index(one)])
    return (
        joint
        if best == candidate
        else max(joint, PooledCandidate.of(best, besides, problems, tried), key=lambda one: one.gain)
    )


def _likely(
    flat: Sequence[Candidate],
    problems: Sequence[LinearProblem],
    besides: Sequence[ColouredBaseline],
    rests: Sequence[NoiseModel],
) -> list[float]:
    """Nats that the others' coefficients explain in each, summed, beside given rests."""
    found: dict[Candidate, list[CoefficientEstimate]] = {one: [] for one in flat}
    for problem, beside, rest in zip(problems, besides, rests, strict=True):
        rows = {one: beside.rows.taken(each) for one in flat if (each := columns_in(one, problem)) is not None}
        products = informations(beside.rows, beside.inside, list(rows.values()), rest)
        for one, each in zip(rows, products, strict=True):
            found[one].append(estimate(each))
    return [float(left_out_gains(several).sum()) if several else -np.inf for several in found.values()]


def _most_by_chance(joint: PooledCandidate) -> float:
    """Most nats of common coefficients that the effects of none gain together, rolled alike in every recording."""
    turns = zip(*(one.chance for one in joint.there), strict=True)
    scaled = ([estimate(N, one.inflation) for N, one in zip(turn, joint.there, strict=True)] for turn in turns)
    return max(float(left_out_gains(several).sum()) for several in scaled)


def _adds(found: TransferFinding, members: Sequence[PooledRecording], with_it: Sequence[PooledRecording]) -> bool:
    """Whether it explains a share of the gap where it is present."""
    pairs = zip(members, with_it, found.there, strict=True)
    shares = [added_share(a.start, a.ground, b.ground.squares) for a, b, there in pairs if there is There.PRESENT]
    return float(np.mean(shares or [0.0])) >= members[0].problem.policy.least_added


def _along_the_field(
    found: TransferFinding, members: Sequence[PooledRecording], with_it: Sequence[PooledRecording]
) -> bool:
    """Whether a field of its own gains along the field in half the recordings at least."""
    asked = [
        gains_along_the_field(before.ground, after.ground)
        for before, after, there in zip(members, with_it, found.there, strict=True)
        if there is There.PRESENT
        and before.problem.mode == "vector"
        and found.joint.candidate.effect.traits.field_source
    ]
    return not asked or 2 * sum(asked) >= len(asked)


def _named(
    best: PooledCandidate,
    found: TransferFinding,
    tried: Sequence[PooledCandidate],
    settings: Settings,
    members: Sequence[PooledRecording],
    *,
    coloured: bool,
) -> Chosen:
    """The simplest of those as good as the best and of its kin, and all others that look like it in all recordings."""
    problems = [one.problem for one in members]
    closest, alike = look_alikes(best, tried, problems[0].policy, coloured=coloured)
    chosen = simplest(closest, problems[0].policy)
    names = dict.fromkeys([*(one.name for one in (*closest, *alike)), *explain_as_much(found, settings, problems)])
    simpler = found if chosen is best else _finding(chosen, members, coloured=coloured)
    last = found if simpler.reach is None else simpler
    if last.reach is Transfer.NOT_TRANSFERRED:
        names |= dict.fromkeys(_listed_by_each(last.joint.name, members))
    return Chosen(last, tuple(name for name in names if name != last.joint.name))


def _listed_by_each(name: str, members: Sequence[PooledRecording]) -> list[str]:
    """What every recording that names an effect by itself does not tell from it.

    Of coefficients that differ the others say nothing.
    """
    own = [one.alternatives for member in members for one in member.named if one.name == name]
    return [other for other in own[0] if all(other in each for each in own)] if own else []


def _is_form(best: Chosen, chosen: Sequence[Chosen], first: Sequence[ColouredBaseline], policy: Policy) -> bool:
    """Whether an effect is only the form of what is in: of its kin, or smaller by far.

    first : the rows without any effect. What is much smaller than alone looked like what is in.
    """
    if not chosen:
        return False
    kin = any(are_kin(best.finding.joint, one.finding.joint) for one in chosen)
    same = any(best.name == one.name for one in chosen)
    like = best.strength < policy.shrunk_form * best.alone(first).strength
    share = policy.same_form_share if same or like else policy.form_share
    return kin or best.strength < share * chosen[0].strength


def _not_borne_out(
    members: Sequence[PooledRecording], settings: Settings, chosen: Sequence[Chosen]
) -> list[TransferFinding]:
    """What a recording alone names and the lot does not, asked beside what the lot believes."""
    known = {name for one in chosen for name in (one.name, *one.alternatives)}
    alone = {one.name: one.evidence.candidate for member in members for one in member.named if one.name not in known}
    besides = [ColouredBaseline.of(one.problem, one.ground.inside) for one in members] if alone else []
    problems = [one.problem for one in members]
    joints = [joint_of(candidate, settings[name], besides, problems) for name, candidate in alone.items()]
    return [replace(_finding(joint, members, coloured=True), reach=None) for joint in joints]
