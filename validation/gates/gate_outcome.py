"""Progress of a gate through trials, and the outcome."""

from __future__ import annotations

from collections import Counter
from dataclasses import dataclass, field
from functools import cached_property

import numpy as np

from scenarios.arrays import Array
from validation.gates.gate_plan import GatePlan
from validation.gates.power import factor_seen, more_trials, smallest_exceedance
from validation.gates.sequential import Decision, Verdict, decide


@dataclass(frozen=True)
class GateTrial:
    """Score of a trial for a gate.

    score : infinite in a failed trial, with the reason in `failure`. reference_score : the score that multiplies the
    limit, 1 for a limit in the unit of the score.
    """

    score: float
    reference_score: float = 1.0
    failure: str = ""


@dataclass
class GateProgress:
    """Trials of a gate so far, in the order of runs, up to the deciding trial."""

    plan: GatePlan
    trials: list[GateTrial] = field(default_factory=list)
    exceeded: list[bool] = field(default_factory=list)
    decided: bool = False

    @property
    def finished(self) -> bool:
        """Whether the gate is decided or out of trials."""
        return self.decided or len(self.trials) >= self.plan.max_trials

    def add(self, trial: GateTrial) -> None:
        """Add a trial and test for a decision; a failed trial, and a trial without a finite limit, exceed."""
        self.trials.append(trial)
        limit = self.plan.gate.factor * trial.reference_score
        within = np.isfinite(trial.score) and np.isfinite(limit) and trial.score <= limit
        self.exceeded.append(not within)
        k, n, test = sum(self.exceeded), len(self.trials), self.plan.test
        self.decided = bool(test.over(k, n) >= test.failing or test.within(k, n) >= test.passing)


@dataclass(frozen=True)
class GateOutcome:
    """Verdict of a gate with the evidence; scores and reference_scores (n,) as in `GateTrial`."""

    plan: GatePlan
    decision: Decision
    scores: Array
    reference_scores: Array
    failures: Counter[str]

    @classmethod
    def of(cls, progress: GateProgress) -> GateOutcome:
        """Return the outcome of finished progress."""
        return cls(
            progress.plan,
            decide(progress.plan.test, progress.exceeded),
            np.array([trial.score for trial in progress.trials]),
            np.array([trial.reference_score for trial in progress.trials]),
            Counter(trial.failure for trial in progress.trials if trial.failure),
        )

    @property
    def verdict(self) -> Verdict:
        """Verdict: pass, fail or inconclusive."""
        return self.decision.verdict

    @cached_property
    def values(self) -> Array:
        """Values compared with the limit (n,): score / reference score, infinite in a failed trial."""
        with np.errstate(all="ignore"):
            ratios = self.scores / self.reference_scores
        return np.where(np.isfinite(self.scores), np.nan_to_num(ratios, nan=1.0, posinf=np.inf), np.inf)

    @property
    def failure(self) -> str:
        """Most frequent reason of a failed trial, "" where none failed."""
        return next((text for text, _ in self.failures.most_common(1)), "")

    @property
    def measured(self) -> float:
        """The gate's quantile of the values; infinite where too many trials failed."""
        return float(np.quantile(self.values, self.plan.gate.quantile, method="higher"))

    @cached_property
    def exceedance_seen(self) -> float:
        """Smallest P(exceed) that fails with the power of the gate."""
        return smallest_exceedance(self.plan.test, self.plan.max_trials, self.plan.gate.power)

    @property
    def factor_seen(self) -> float:
        """Smallest detectable defect, as a factor on the measured scores; detected with the power of the gate."""
        with np.errstate(over="ignore"):  # of a limit next to zero
            ratios = self.values / self.plan.gate.factor
        return factor_seen(ratios, self.exceedance_seen)

    @property
    def smallest_seen(self) -> float:
        """Smallest detectable value of the quantile, in the unit of the limit."""
        return self.factor_seen * self.measured if np.isfinite(self.measured) else np.inf

    @property
    def more_trials(self) -> int | None:
        """Further trials that decide an inconclusive gate at the measured rate; None above MOST_TRIALS."""
        return more_trials(self.plan.test, int(self.decision.exceeded.sum()), self.decision.trials)
