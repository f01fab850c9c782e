"""The choice of an effect where what is left is coloured: each candidate beside a rest of its own."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import cached_property

from diagnosis.decision.screening import Screening
from diagnosis.decision.white_choice import Accepted, Round, are_kin, instead_of, of_one_course, simplest
from diagnosis.evidence.attitude_like import TURNS, an_attitude_does_as_well
from diagnosis.evidence.attitude_wander import a_wander_does_better, beside_a_wander
from diagnosis.evidence.baseline import Baseline, IsClean, added_share
from diagnosis.evidence.candidate_result import TOO_LITTLE, CandidateResult
from diagnosis.evidence.candidate_test import (
    CandidateFit,
    ColouredBaseline,
    gained_along_the_field,
    gains_along_the_field,
    look_alikes,
    share_along_the_field,
)
from diagnosis.evidence.constancy import differs_along_the_run
from diagnosis.evidence.heading_harmonics import goes_with_heading, swings_with_the_field
from diagnosis.evidence.held_out import Evidence
from diagnosis.evidence.smooth_course import (
    a_course_of_the_field_does_better,
    a_course_of_the_place_does_better,
    a_course_of_time_does_better,
)
from diagnosis.evidence.smooth_windows import comes_and_goes
from diagnosis.evidence.windowed_candidates import comes_again
from diagnosis.policy import Policy
from sim.effects import EFFECTS

NOT_ALONG = "nothing along the field: an error of the attitude"
DENIED_ALONG = "adds along the field what is not there: an error of the attitude"
OF_MANY_SIZES = "of another size in each part of the run"
OF_ERRORS = "hardly shown by the motion: what is left of it are the attitude's errors"
WANDERS = "less than an attitude that wanders"
OF_ATTITUDE = (NOT_ALONG, WANDERS)
BY_ANOTHER = (*OF_ATTITUDE, DENIED_ALONG, OF_MANY_SIZES)
"""Refusals that may be for what another effect leaves."""
Next = Callable[[Baseline, Evidence], Accepted | None]
"""(ground with an effect in, that one) -> what is found beside it."""


def beside_colour(
    ground: Baseline,
    ranking: Sequence[Evidence],
    start: Baseline,
    is_clean: IsClean,
    windowed: Sequence[Evidence] = (),
    fuller: Sequence[Evidence] = (),
    beyond: Next | None = None,
) -> Round:
    """The candidate that beats a rest with its own colour; one rest for all would swallow it, or take it for granted.

    start : the ground without any effect, whose gap a share is of. windowed : candidates that act in a part of the run.
    fuller : candidates with a form from the start, each in place of the plain one where that gains less. beyond : what
    is found beside one that does not stand alone.
    """
    beside, policy = ColouredBaseline.of(ground.problem, ground.inside), ground.problem.policy
    look = Screening.of([*ranking, *fuller], beside, ground)
    first, most = look.in_turn(ground, start), policy.tried_coloured
    tried = sorted((look.heard(one, beside) for one in first[:most]), key=lambda one: -one.gain)
    tried = [*_far_better(windowed, tried, beside, ground), *tried]
    trials = _until_one_stands(CandidateTest(ground, beside, start, is_clean, beyond), tried)
    chosen = _chosen(trials, tried, beside, look.several)
    others = [(look.several[i], float(look.nats[i])) for i in first[most:]]
    return Round.of(chosen, [*_heard(trials, tried), *_unheard(trials, others, policy)])


def _far_better(
    windowed: Sequence[Evidence], tried: Sequence[CandidateFit], beside: ColouredBaseline, ground: Baseline
) -> list[CandidateFit]:
    """Candidates in a window that gain far more than any does in the whole run, the strongest first."""
    policy, problem = ground.problem.policy, ground.problem
    always = max((one.gain for one in tried), default=0.0)
    both = (beside.standing(e, beside.rows.taken(e.candidate.columns(problem))) for e in windowed)
    far = [one for one in both if one.gain > max(always / policy.window_share, always + policy.coloured_nats)]
    return sorted(far, key=lambda one: -one.gain)


@dataclass(frozen=True)
class CandidateTrial:
    """A candidate tried beside a rest of its own: what chance inflates its evidence by, and why it does not stand.

    turned : an error of the attitude does as well.
    """

    one: CandidateFit
    inflation: float
    coloured: bool
    needed: float
    refusal: str
    turned: bool = False

    @property
    def may_be_less(self) -> bool:
        """Whether a simpler effect may stand in its place."""
        return self.coloured or self.turned


@dataclass(frozen=True)
class CandidateTest:
    """What candidates of a round are tried against."""

    ground: Baseline
    beside: ColouredBaseline
    start: Baseline
    is_clean: IsClean
    beyond: Next | None = None

    @cached_property
    def wander(self) -> ColouredBaseline | None:
        """The same beside an attitude that wanders."""
        return beside_a_wander(self.beside, self.ground.problem)

    def stands_beside_another(self, one: CandidateFit, refusal: str) -> bool:
        """Whether a candidate stands once the next effect is in, which is found with this one in.

        Of two effects the larger may be refused for what the other leaves: neither stands by itself, each beside the
        other. Two of the field are pieces of the course that an attitude's error has, and no witness of each other.
        """
        problem = self.ground.problem
        if self.beyond is None:
            return False
        other = self.beyond(self.ground.beside(one.evidence.candidate.columns(problem)), one.evidence)
        if other is None or other.name == one.evidence.name:
            return False
        if refusal in OF_ATTITUDE and _of_the_field(other.evidence) and _of_the_field(one.evidence):
            return False
        ground = self.ground.beside(other.columns(problem))
        hearing = CandidateTest(ground, ColouredBaseline.of(problem, ground.inside), self.start, self.is_clean)
        return not hearing.of(hearing.beside.standing(one.evidence, one.columns)).refusal

    def of(self, one: CandidateFit) -> CandidateTrial:
        """A candidate on trial."""
        policy = self.ground.problem.policy
        with_it = self.ground.beside(one.evidence.candidate.columns(self.ground.problem))
        coloured = not self.is_clean(with_it, one.evidence.name)
        by_chance = self.beside.surrogates(one, self.ground.problem)
        inflation = max(1.0, 2 * float(by_chance.mean()) / one.columns.shape[2])
        needed = policy.coloured_nats if coloured else policy.accepted(len(EFFECTS))
        if one.gain / inflation <= needed:
            refusal = TOO_LITTLE
        elif one.gain <= by_chance.max():
            refusal = "no more than its columns moved in time"
        else:
            refusal = self._refusal(one, with_it, coloured) or self._refusal_by_wander(one, with_it, coloured, needed)
        asked = not (refusal or coloured)
        turned = asked and an_attitude_does_as_well(self.ground, with_it, one.evidence.candidate)
        return CandidateTrial(one, inflation, coloured, needed, refusal, turned)

    def _refusal(self, one: CandidateFit, with_it: Baseline, coloured: bool) -> str:
        """Why what gains enough is no cause, if it is none."""
        return (
            self._refusal_by_survival(one.evidence, coloured)
            or self._refusal_by_size(one, coloured)
            or self._refusal_by_course(one.evidence, with_it)
            or self._refusal_by_share(with_it, coloured)
            or self._refusal_along_the_field(one, with_it, coloured)
            or self._refusal_by_any_course(one, coloured)
        )

    def _refusal_by_wander(self, one: CandidateFit, with_it: Baseline, coloured: bool, needed: float) -> str:
        """Why it is a part of an error of the attitude; a field of its own is none that explains what is along it."""
        source = one.evidence.candidate.effect.traits.field_source and with_it.problem.sees_across
        if not coloured or (source and self._is_along_the_field(with_it, needed)):
            return ""
        return WANDERS if a_wander_does_better(one, self.wander, needed) else ""

    def _is_along_the_field(self, with_it: Baseline, needed: float) -> bool:
        """Whether what is along the field is explained, by the evidence that is needed: a wander has nothing there."""
        enough = share_along_the_field(self.ground, with_it) > with_it.problem.policy.along_share
        return enough and gained_along_the_field(self.ground, with_it) > needed

    def _refusal_by_survival(self, one: Evidence, coloured: bool) -> str:
        """Why what the base leaves of it is no cause: fitted to errors, it makes up for those of the attitude."""
        turns = self.ground.problem.turns and not {"attitude", "rate"}.isdisjoint(one.candidate.effect.needs)
        return OF_ERRORS if coloured and turns and one.survival < self.ground.problem.policy.survival_of_errors else ""

    def _refusal_by_size(self, one: CandidateFit, coloured: bool) -> str:
        policy = self.ground.problem.policy
        share = policy.other_size_coloured if coloured else policy.other_size
        return OF_MANY_SIZES if differs_along_the_run(one, self.beside, share) else ""

    def _refusal_by_course(self, one: Evidence, with_it: Baseline) -> str:
        """Why it is no tone, or has no window."""
        if goes_with_heading(self.ground, one):
            return "goes with the heading as well"
        if swings_with_the_field(self.ground, one):
            return "goes with the field in the earth's frame rather"
        if course := comes_and_goes(self.ground, one.candidate):
            return f"comes and goes with {course} as well"
        return "comes again beside its own window" if comes_again(self.ground, with_it, one.candidate) else ""

    def _refusal_by_share(self, with_it: Baseline, coloured: bool) -> str:
        too_little = added_share(self.start, self.ground, with_it.squares) < self.ground.problem.policy.least_added
        return "explains next to nothing of the gap" if coloured and too_little else ""

    def _refusal_by_any_course(self, one: CandidateFit, coloured: bool) -> str:
        """Why it is a part of a slow disturbance."""
        if coloured and a_course_of_time_does_better(one, self.beside, self.ground.problem):
            return "less than any smooth course of time"
        if coloured and a_course_of_the_field_does_better(one, self.beside, self.ground.problem):
            return "less than any smooth course of the field"
        of_place = coloured and a_course_of_the_place_does_better(one, self.beside, self.ground.problem)
        return "less than a field that changes with the place" if of_place else ""

    def _refusal_along_the_field(self, one: CandidateFit, with_it: Baseline, coloured: bool) -> str:
        """Why it is an error of the attitude; what leaves nothing need not show along the field, but not deny it."""
        problem, candidate = self.ground.problem, one.evidence.candidate
        source = candidate.effect.traits.field_source
        if not problem.sees_across or not (coloured or source):
            return ""
        turned = source or problem.level is not None  # all that the dip has may be roll's and pitch's
        if coloured and turned and not gains_along_the_field(self.ground, with_it, candidate.tried):
            return NOT_ALONG
        if gained_along_the_field(self.ground, with_it) < -problem.policy.apart:
            return DENIED_ALONG
        return ""


def _of_the_field(one: Evidence) -> bool:
    return one.candidate.effect.stage == "field"


def _until_one_stands(hearing: CandidateTest, tried: Sequence[CandidateFit]) -> list[CandidateTrial]:
    """Trials in their order up to the first that stands.

    The strongest of all is also tried beside another, and so is the strongest that a wander does better than.
    """
    trials: list[CandidateTrial] = []
    for one in tried:
        trial = hearing.of(one)
        first = one is tried[0] or (trial.refusal == WANDERS and all(t.refusal != WANDERS for t in trials))
        doubted = first and trial.refusal in BY_ANOTHER
        if doubted and hearing.stands_beside_another(one, trial.refusal):
            trial = replace(trial, refusal="")
        trials.append(trial)
        if not trial.refusal:
            break
    return trials


def _heard(trials: Sequence[CandidateTrial], tried: Sequence[CandidateFit]) -> list[CandidateResult]:
    """The candidates with a rest of their own; those that were not tried any more by the last one's inflation."""
    if not trials:
        return []
    last = trials[-1]
    rest = [replace(last, one=one, refusal="") for one in tried[len(trials) :]]
    return [CandidateResult(t.one.evidence, t.one.gain / t.inflation, t.needed, t.refusal) for t in (*trials, *rest)]


def _unheard(
    trials: Sequence[CandidateTrial], others: Sequence[tuple[Evidence, float]], policy: Policy
) -> list[CandidateResult]:
    """The candidates that gain less beside the rest as it is, by what they gain there."""
    inflation = trials[-1].inflation if trials else 1.0
    return [CandidateResult(e, gain / inflation, policy.coloured_nats, "") for e, gain in others]


def _chosen(
    trials: Sequence[CandidateTrial],
    tried: Sequence[CandidateFit],
    beside: ColouredBaseline,
    ranking: Sequence[Evidence],
) -> Accepted | None:
    """The one that stands, with what looks like it of those that were not refused, and errors of the attitude."""
    if not trials or trials[-1].refusal:
        return None
    refused = {trial.one for trial in trials if trial.refusal}
    chosen = _named(trials[-1], [one for one in tried if one not in refused], beside)
    if not trials[-1].turned:
        return chosen
    names = dict.fromkeys((*chosen.alternatives, *(one.name for one in ranking if one.name in TURNS)))
    return replace(chosen, alternatives=tuple(name for name in names if name != chosen.name))


def _named(trial: CandidateTrial, tried: Sequence[CandidateFit], beside: ColouredBaseline) -> Accepted:
    """The simplest of those as good as the best and of its kin, and all others that look like it."""
    policy, best = beside.rows.policy, trial.one
    chance = policy.apart * trial.inflation
    others = [one for one in tried if one is not best]
    alike = look_alikes(best, others, beside, chance, policy.same_coloured) if trial.coloured else []
    narrow = _as_good(trial, others, beside, chance)
    close = {one: _deflated(one, trial.inflation) for one in (*narrow, *alike)}
    chosen = simplest([close[one] for one in narrow], policy)
    return Accepted(chosen, instead_of(chosen, list(close.values()), policy), trial.needed)


def _as_good(
    trial: CandidateTrial, others: Sequence[CandidateFit], beside: ColouredBaseline, chance: float
) -> list[CandidateFit]:
    """The best with those that gain as much by chance, or but for an error of form: of its kin, or within it."""
    policy, best = beside.rows.policy, trial.one
    kin = [one for one in others if are_kin(one.evidence, best.evidence)]
    within = [one for one in others if one.evidence.name in best.evidence.candidate.effect.traits.contains]
    of_form = policy.same_kin_coloured if trial.coloured else policy.same_kin
    of_simpler = policy.same_kin if trial.may_be_less else policy.same_constant
    as_good = look_alikes(best, others, beside, chance, 0.0)
    of_its_kin = look_alikes(best, kin, beside, chance, of_form)
    simpler = look_alikes(best, within, beside, chance, of_simpler)
    slow = [one for one in others if of_one_course(one.evidence, best.evidence, policy)]
    return list(dict.fromkeys([best, *as_good, *of_its_kin, *simpler, *slow]))


def _deflated(one: CandidateFit, inflation: float) -> Evidence:
    return replace(one.evidence, gain=one.gain, V=inflation)
