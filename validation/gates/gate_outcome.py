"""A gate on its way through the trials, and what came of it."""

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
    """What one trial says to a gate.

    score : infinite without an estimate, and then `trouble` says why; other : the score that the limit is a multiple
    of, 1 for a limit in the score's unit.
    """

    score: float
    other: float = 1.0
    trouble: str = ""


@dataclass
class GateProgress:
    """A gate's trials so far, in the order of runs; none is taken in after the one that decides."""

    plan: GatePlan
    trials: list[GateTrial] = field(default_factory=list)
    exceeded: list[bool] = field(default_factory=list)
    decided: bool = False

    @property
    def finished(self) -> bool:
        """Whether the gate is decided, or out of trials."""
        return self.decided or len(self.trials) >= self.plan.max_trials

    def take(self, trial: GateTrial) -> None:
        """Look at one more trial; one without an estimate is over any limit."""
        self.trials.append(trial)
        within = np.isfinite(trial.score) and trial.score <= self.plan.gate.factor * trial.other
        self.exceeded.append(not within)
        k, n, test = sum(self.exceeded), len(self.trials), self.plan.test
        self.decided = bool(test.over(k, n) >= test.failing or test.within(k, n) >= test.passing)


@dataclass(frozen=True)
class GateOutcome:
    """A gate's verdict with everything that it rests on; scores and others (n,) as in `GateTrial`."""

    plan: GatePlan
    decision: Decision
    scores: Array
    others: Array
    troubles: Counter[str]

    @classmethod
    def of(cls, progress: GateProgress) -> GateOutcome:
        """What a progress came to."""
        return cls(
            progress.plan,
            decide(progress.plan.test, progress.exceeded),
            np.array([trial.score for trial in progress.trials]),
            np.array([trial.other for trial in progress.trials]),
            Counter(trial.trouble for trial in progress.trials if trial.trouble),
        )

    @property
    def verdict(self) -> Verdict:
        """Whether the limit is kept."""
        return self.decision.verdict

    @cached_property
    def values(self) -> Array:
        """What the limit is held against (n,): the score in its unit, or as a multiple of the other."""
        with np.errstate(all="ignore"):
            ratios = self.scores / self.others
        return np.where(np.isfinite(self.scores), np.nan_to_num(ratios, nan=1.0, posinf=np.inf), np.inf)

    @property
    def trouble(self) -> str:
        """Why there was mostly no estimate; empty where there always was one."""
        return next((text for text, _ in self.troubles.most_common(1)), "")

    @property
    def measured(self) -> float:
        """The gate's quantile of the values; infinite where so many trials gave no estimate."""
        return float(np.quantile(self.values, self.plan.gate.quantile, method="higher"))

    @cached_property
    def exceedance_seen(self) -> float:
        """The smallest P(exceed) that would have failed with the gate's power."""
        return smallest_exceedance(self.plan.test, self.plan.max_trials, self.plan.gate.power)

    @property
    def factor_seen(self) -> float:
        """The smallest defect that would have failed with the gate's power, as a factor on these trials' scores."""
        return factor_seen(self.values / self.plan.gate.factor, self.exceedance_seen)

    @property
    def smallest_seen(self) -> float:
        """The same as the quantile that it gives, in the unit of the limit."""
        return self.factor_seen * self.measured if np.isfinite(self.measured) else np.inf

    @property
    def more_trials(self) -> int | None:
        """Of an undecided gate, how many more trials decide at the rate measured; None for more than can be run."""
        return more_trials(self.plan.test, int(self.decision.exceeded.sum()), self.decision.trials)
