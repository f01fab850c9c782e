"""Effects selected so far, and the choice among candidates: the simplest of those that explain as much as the best."""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Protocol, TypeVar

import numpy as np

from diagnosis.evidence.along_field import within_stated_errors
from diagnosis.evidence.baseline import Baseline
from diagnosis.evidence.candidate_test import ColouredBaseline
from diagnosis.evidence.held_out import CandidateResult, Evidence
from diagnosis.evidence.noise_model import NoiseModel
from diagnosis.evidence.residual_tests import ResidualTests, run_residual_tests
from diagnosis.evidence.slow_noise import SlowNoise
from diagnosis.library.candidates import Candidate
from diagnosis.policy import Policy
from diagnosis.problem.linear import LinearProblem
from scenarios.arrays import Array
from sim.effects import BY_NAME, EFFECTS

CHAIN_ORDER = tuple(BY_NAME)


@dataclass(frozen=True)
class AcceptedEffect:
    """An accepted effect, its look-alikes, its evidence and the evidence needed, in nats.

    form_of : name of an accepted effect whose form error this effect fits; such an effect is no second cause.
    """

    evidence: Evidence
    alternatives: tuple[str, ...]
    needed: float | None = None
    form_of: str | None = None

    @property
    def name(self) -> str:
        """Name of the effect."""
        return self.evidence.name

    def columns(self, problem: LinearProblem) -> Array:
        """Columns (n, q, k) of the effect."""
        return self.evidence.candidate.columns(problem)

    def refitted(self, evidence: Evidence) -> AcceptedEffect:
        """The effect with another fit; the nats stay those by which it was accepted."""
        return replace(self, evidence=replace(evidence, gain=self.evidence.gain, V=self.evidence.V))

    def listing(self, *names: str) -> AcceptedEffect:
        """The effect with further look-alikes."""
        others = dict.fromkeys((*self.alternatives, *names))
        return replace(self, alternatives=tuple(name for name in others if name != self.name))


@dataclass(frozen=True)
class Selection:
    """Result of the selection: accepted effects in order, baselines and residual tests before and after.

    without: names left out of the library. results: every candidate of the first round, the strongest first. iron,
    conventional: changes of the iron that are findings, and those that restate an effect's reference. noise: slow noise
    beside all these. The last three are found by `conclude`.
    """

    accepted: tuple[AcceptedEffect, ...]
    start: Baseline
    end: Baseline
    before: ResidualTests
    after: ResidualTests
    results: tuple[CandidateResult, ...]
    without: frozenset[str]
    iron: tuple[AcceptedEffect, ...] = ()
    conventional: tuple[AcceptedEffect, ...] = ()
    noise: SlowNoise | None = None

    @property
    def clean(self) -> bool:
        """Whether the residual is white, or explained by slow noise."""
        return self.after.clean or self.noise is not None

    @cached_property
    def coloured_noise(self) -> NoiseModel | None:
        """The noise model of a sample beside the accepted effects, if a coloured residual is left; vector mode only."""
        if self.end.problem.mode != "vector" or self.after.clean or not self.accepted:
            return None
        found = ColouredBaseline.of(self.end.problem, self.end.accepted_columns)
        samples, noise = float(np.median(found.rows.count)), found.hypothesis.noise_model
        return replace(noise, slow=noise.slow / samples)  # a row sums so many samples, over the root of their number

    @property
    def names(self) -> list[str]:
        """Names of the accepted effects."""
        return [effect.name for effect in self.accepted]

    def beside(self, end: Baseline, *further: str) -> Selection:
        """The selection beside another baseline, which holds the columns of further effects, by name."""
        return replace(self, end=end, after=residual_tests(end, [*self.names, *further]))

    def is_clean(self, end: Baseline, *further: str) -> bool:
        """Whether the selection beside another baseline leaves white noise."""
        return self.beside(end, *further).after.clean


def baseline_with(accepted: Iterable[AcceptedEffect], start: Baseline) -> Baseline:
    """The baseline with effects; large for a long recording, hence kept no longer than needed."""
    return start.with_all(effect.columns(start.problem) for effect in accepted)


def residual_tests(baseline: Baseline, names: Sequence[str]) -> ResidualTests:
    """Test the residual of a baseline with effects of these names; slow errors stated by the model pass.

    After a low-pass or a delay the noise is correlated over some samples.
    """
    problem, residual = baseline.problem, baseline.residual()
    fitted = problem.fitted + baseline.sums.width
    filtered = any(BY_NAME[name].traits.correlates_noise for name in names)
    samples = problem.policy.filter_memory if filtered else 1
    usable, time_s, tails = problem.usable, problem.state.time_s, not problem.wrong_values
    tests = run_residual_tests(residual, usable, time_s, fitted, problem.policy, samples, tails=tails)
    return tests if tests.clean or not within_stated_errors(problem, residual) else replace(tests, why=())


def accept_best(ranking: Sequence[Evidence], policy: Policy, *, clean: bool = True) -> AcceptedEffect | None:
    """Accept the best candidate, or the simplest of those as good, if the best has enough nats of white noise.

    clean : whether the residual is white; coloured noise needs more evidence.
    """
    needed, form = policy.accepted(len(EFFECTS)) if clean else policy.coloured_nats, policy.same_family
    if not ranking or ranking[0].nats <= needed:
        return None
    as_good = (evidence for evidence in ranking if is_as_good(evidence, ranking[0], policy, form, form))
    return accept_simplest([evidence for evidence in as_good if evidence.nats > policy.apart], (), needed, policy)


def accept_simplest(
    as_good: Sequence[Evidence], alike: Sequence[Evidence], needed: float, policy: Policy
) -> AcceptedEffect:
    """Accept the simplest of equally good candidates, with the look-alikes among these and further ones.

    An effect that contains the chosen one is listed only where it gains more than chance: with its extra columns at
    zero both agree.
    """
    chosen = select_simplest(as_good, policy)
    names = (
        evidence.name
        for evidence in (*as_good, *alike)
        if chosen.name not in evidence.candidate.effect.traits.contains or chosen.is_behind(evidence, policy)
    )
    return AcceptedEffect(chosen, (), needed).listing(*names)


def is_as_good(candidate: _Comparable, best: _Comparable, policy: Policy, form: float, simpler: float) -> bool:
    """Whether a candidate gains as much as the best but for chance, or but for a form error.

    form, simpler : share of the best gain by which the best's family, or an effect that the best contains, may gain
    less.
    """
    family = form if in_same_family(candidate, best) else 0.0
    contained = simpler if candidate.name in best.candidate.effect.traits.contains else 0.0
    return best.gain - candidate.gain <= max(policy.apart * best.V, max(family, contained) * best.gain)


class _Comparable(Protocol):
    """A candidate with gain in nats, their inflation V, number of columns, and how far it is from its own size."""

    @property
    def candidate(self) -> Candidate: ...
    @property
    def name(self) -> str: ...
    @property
    def gain(self) -> float: ...
    @property
    def V(self) -> float: ...
    @property
    def width(self) -> int: ...
    @property
    def scale_error(self) -> float: ...


R = TypeVar("R", bound=_Comparable)


def select_simplest(close: Sequence[R], policy: Policy) -> R:
    """The strongest of the candidates with the fewest columns; of identical candidates, the first in the chain.

    Hard iron and sensor offset span the same columns: rounding decides which gains more. `Traits.equivalent_to`
    states further identities.
    """
    narrowest = min(candidate.width for candidate in close)
    rivals = [candidate for candidate in close if candidate.width == narrowest]
    best = max(rivals, key=lambda candidate: candidate.gain)
    if family := [candidate for candidate in rivals if in_same_family(candidate, best)]:
        return _select_in_family(family, policy)
    twin = best.candidate.effect.traits.equivalent_to
    identical = (
        candidate
        for candidate in rivals
        if candidate.name == twin or math.isclose(candidate.gain, best.gain, rel_tol=policy.same_gain)
    )
    return min(identical, key=lambda candidate: CHAIN_ORDER.index(candidate.name))


def _select_in_family(family: Sequence[R], policy: Policy) -> R:
    """The family member nearest to its own size, else the last in the chain: two low-passes resemble a delay."""
    nearest = min(candidate.scale_error for candidate in family)
    near = [candidate for candidate in family if candidate.scale_error < nearest + policy.same_size]
    most = max(candidate.gain for candidate in near)
    as_good = (candidate for candidate in near if most - candidate.gain < policy.apart)
    return max(as_good, key=lambda candidate: CHAIN_ORDER.index(candidate.name))


def in_same_family(first: _Comparable, second: _Comparable) -> bool:
    """Whether two effects agree to first order."""
    family = first.candidate.effect.traits.family
    return bool(family) and family == second.candidate.effect.traits.family


def is_form_by_size(strength: float, alone: float, first: float, policy: Policy, *, same: bool) -> bool:
    """Whether an effect is small enough for a form error of the first effect, given its strength alone.

    same : whether the effect was accepted before. A size far below that alone shows resemblance to accepted effects.
    """
    resembles = strength < policy.half * alone
    return strength < (policy.same_form_share if same or resembles else policy.form_share) * first
