"""Probability that white noise has the nats of a name, from scores drawn in place of whole recordings.

    python -m benchmarks.diagnosis.false_names --seed 700 --draws 20000

In white noise every gain is a function of the scores ``X_f' y`` of each fold f, which are normal with covariance ``X_f'
X_f``, X the columns of base and candidates. Effects whose parameter is searched over the recording, and pay for the
search, are left out, and so is the inflation V, which lowers evidence.
"""

from __future__ import annotations

import argparse
import itertools
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from benchmarks.diagnosis.motion import flown, motions
from benchmarks.diagnosis.trials import measured
from benchmarks.diagnosis.truth import BASE
from benchmarks.diagnosis.wide.courses import DRAWN
from benchmarks.diagnosis.wide.making import null
from diagnosis.evidence.baseline import Baseline
from diagnosis.library.candidates import Candidate, iron_candidates, propose_candidates
from diagnosis.problem.formulation import pose_model
from diagnosis.problem.linear import LinearProblem
from scenarios.arrays import Array
from sim.effects import EFFECTS
from sim.scenario import ModelSpec

Folds = NDArray[np.bool_]


@dataclass(frozen=True, eq=False)
class Scores:
    """Scores (f, draws, m) of white noise in each fold, with their information (f, m, m); the base's columns first."""

    information: Array
    drawn: Array
    base: int

    @classmethod
    def of(cls, baseline: Baseline, columns: Array, draws: int, rng: np.random.Generator) -> Scores:
        """Scores of the base and of further columns (n, q, k)."""
        s = baseline.sums_with(columns)
        folds, p, q, _ = s.BC.shape
        BB, BE = np.stack([np.kron(one, np.eye(q)) for one in s.BB]), s.BC[:, :, :, 1:].reshape(folds, p * q, -1)
        upper = np.concatenate([BB, BE], axis=2)
        information = np.concatenate([upper, np.concatenate([BE.transpose(0, 2, 1), s.CC[:, 1:, 1:]], axis=2)], axis=1)
        size = np.sqrt(np.maximum(np.einsum("fmm->m", information), 1e-300))
        information /= np.outer(size, size)
        values, vectors = np.linalg.eigh(information)
        root = vectors * np.sqrt(np.maximum(values, 0.0))[:, None, :]
        return cls(information, rng.normal(size=(folds, draws, len(size))) @ root.transpose(0, 2, 1), p * q)

    def likelihoods(self, columns: slice, train: Folds, held: Folds) -> Array:
        """Log-likelihoods (2, draws) of base and candidate, fitted to folds: on these, and on the held-out folds."""
        use = np.r_[: self.base, columns]
        information, scores = self.information[:, use[:, None], use], self.drawn[:, :, use]
        c = scores[train].sum(axis=0) @ np.linalg.pinv(information[train].sum(axis=0), rcond=1e-12, hermitian=True)
        each = (scores[folds].sum(axis=0) - c @ information[folds].sum(axis=0) / 2 for folds in (train, held))
        return np.stack([(c * rest).sum(axis=1) for rest in each])

    def gains(self, settings: Sequence[slice], splits: Sequence[Folds], times: int) -> Array:
        """Nats (draws,) of the setting that fits the training folds best, at most those on all folds; as judged."""
        every, none = np.ones(len(self.information), bool), slice(self.base, self.base)
        on_all = max_of(self.likelihoods(one, every, every)[0] for one in settings)
        total = np.zeros(self.drawn.shape[1])
        for held in splits:
            trained, held_out = np.stack([self.likelihoods(one, ~held, held) for one in settings], axis=1)
            best = np.argmax(trained, axis=0)
            total += np.take_along_axis(held_out, best[None], axis=0)[0] - self.likelihoods(none, ~held, held)[1]
        return np.asarray(np.minimum(total / times, on_all - self.likelihoods(none, every, every)[0]))


def max_of(several: Iterator[Array]) -> Array:
    """The largest of several arrays, element by element."""
    return np.asarray(np.max(list(several), axis=0))


def best_nats(baseline: Baseline, listed: dict[str, list[Candidate]], draws: int, seed: int) -> dict[str, Array]:
    """Nats (draws,) of each effect in white noise."""
    policy, rng = baseline.problem.policy, np.random.default_rng(seed)
    parts = [[one.columns(baseline.problem) for one in several] for several in listed.values()]
    scores = Scores.of(baseline, np.concatenate([one for each in parts for one in each], axis=2), draws, rng)
    out, end = dict[str, Array](), scores.base
    for name, each in zip(listed, parts, strict=True):
        ends = np.cumsum([end, *(one.shape[2] for one in each)])
        settings, end = [slice(*pair) for pair in itertools.pairwise(ends)], int(ends[-1])
        out[name] = scores.gains(settings, baseline.splits, policy.held_segments)
    return out


def problems(seed: int) -> Iterator[tuple[str, LinearProblem]]:
    """A problem along each motion of the bench, and along each wide motion of a seed."""
    for motion in motions():
        recording, state, field_enu_nT = flown(motion)
        given = replace(recording, mag_nT=measured({}, state, seed))
        model = ModelSpec.model_validate({"effects": BASE, "field": {"enu_nT": field_enu_nT.tolist()}})
        yield motion, pose_model(given, model, None, None)
    for motion in DRAWN:
        made = null(motion, None, seed, 0)
        yield f"wide {motion}", pose_model(made.recording, made.model, None, None)


def row(problem: LinearProblem, draws: int, seed: int) -> str:
    """Shares of draws with the nats of a name: an effect of the library, a change of the iron, and the likeliest."""
    needed = problem.policy.accepted(len(EFFECTS))
    listed = {name: each for name, each in propose_candidates(problem).items() if not each[0].effect.search_role()}
    bare = replace(problem, base=np.zeros((len(problem.target), 1)))
    found = (
        best_nats(Baseline.of(problem), listed, draws, seed),
        best_nats(Baseline.of(bare), iron_candidates(), draws, seed),
    )
    shares = [100 * float((max_of(iter(one.values())) > needed).mean()) for one in found]
    most = max(found[0], key=lambda name: float((found[0][name] > needed).mean()))
    return f"{shares[0]:.3f} % | {shares[1]:.3f} % | {most} {100 * (found[0][most] > needed).mean():.3f} %"


def main() -> None:
    """Print the shares along each motion."""
    parser = argparse.ArgumentParser(
        prog="python -m benchmarks.diagnosis.false_names", description=(__doc__ or "").split("\n")[0]
    )
    parser.add_argument("--seed", type=int, default=0, help="of the wide motions and of the draws")
    parser.add_argument("--draws", type=int, default=20_000)
    given = parser.parse_args()
    print("| motion | an effect | a change of the iron | the likeliest effect |\n|---|---|---|---|")
    for motion, problem in problems(given.seed):
        print(f"| {motion} | {row(problem, given.draws, given.seed)} |", flush=True)


if __name__ == "__main__":
    main()
