"""Accuracy in a project's own tests: a calibrator's score on a scenario, held to a limit.

>>> from magbench.testing import assert_accuracy
>>> found = assert_accuracy("ellipsoid", "tumble", score="heading_rms_deg", limit=2.0)
>>> found.verdict, found.decision.trials
('pass', 9)

With pytest the fixture `assert_accuracy` is the same function, and the end of the run lists its gates.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING, Any, Literal

from magbench.api.inputs import in_keywords, scenario_from
from scenarios.errors import InputError

if TYPE_CHECKING:
    from os import PathLike
    from typing import TypeAlias

    from calib.base import Calibrator
    from calib.external import Function
    from sim.scenario import Scenario
    from validation.gates.gate_outcome import GateOutcome

    Calibrating: TypeAlias = str | Calibrator | type[Calibrator] | Function
    """A name, module:object, a command with {recording} and {result}, a Calibrator or its class, or a function."""
    AssertAccuracy: TypeAlias = Callable[..., GateOutcome]
    """What the fixture is."""

LISTENERS: list[Callable[[dict[str, Any]], object]] = []
"""Told of every gate that is decided, as gates.json has it; pytest's fixture is one of them while its test runs."""


def assert_accuracy(
    calibrator: Calibrating,
    scenario: str | PathLike[str] | Scenario,
    *,
    score: str,
    limit: float | None = None,
    ratio: float | None = None,
    reference: Calibrating | None = None,
    baseline: str | PathLike[str] | None = None,
    margin: float | None = None,
    overrides: Sequence[str] = (),
    quantile: float | None = None,
    false_fail_rate: float | None = None,
    max_trials: int | None = None,
    smallest_defect: float | None = None,
    power: float | None = None,
    spread: float | None = None,
    seed: int | None = None,
    time_limit_s: float | None = None,
    inconclusive: Literal["fail", "skip"] = "fail",
) -> GateOutcome:
    """Simulate trials until it is decided whether the median of a score keeps a limit; raise AssertionError if not.

    >>> def middle(recording, reference):
    ...     m = recording.mag_nT
    ...     return (m.max(axis=0) + m.min(axis=0)) / 2, [[1, 0, 0], [0, 1, 0], [0, 0, 1]]
    >>> found = assert_accuracy(middle, "tumble", score="offset_error_nT", ratio=0.9, reference="uncorrected")

    calibrator : a name of `magbench list calibrators`, `module:object`, a command `./mycal {recording} {result}`, a
        `magbench.Calibrator`, or a function of (recording, reference); of an array's sensor `name@2`.
    scenario : a name of the catalogue, a file, or what `magbench.load` gives; overrides : `KEY=VALUE` texts.
    score : a name of docs/scores.md of which less is better.
    limit : in the score's unit. Or ratio : a multiple of the score that `reference` has in the same trial. Or
        baseline : a file of `magbench gate --write-baseline`; the limit is margin times its score of the same trial.
    quantile, max_trials, smallest_defect, power, spread, false_fail_rate, seed, time_limit_s : as in a file of gates
        (docs/gates.md), with its defaults; false_fail_rate is of this assertion alone.
    inconclusive : whether an assertion that is still inconclusive after max_trials fails, or skips the test.

    Returns the gate's outcome: verdict, measured, values (n,), smallest_seen and more. An object in memory, and a
    function, is called in this process; module:object and commands run in processes of their own.
    Raises AssertionError; unittest.SkipTest, which pytest knows too; InputError for wrong use.
    """
    __tracebackhide__ = True
    from validation.gates.single_gate import decide_single_gate

    skip = _skips(inconclusive)
    limits = {"limit": limit, "ratio": ratio, "baseline": baseline and str(baseline), "margin": margin}
    planning = {"max_trials": max_trials, "smallest_defect": smallest_defect, "power": power, "spread": spread}
    options = {"false_fail_rate": false_fail_rate, "seed": seed, "time_limit_s": time_limit_s}
    with in_keywords():
        spec = scenario_from(scenario, overrides)
        gate = {"score": score, "quantile": quantile} | limits | planning
        outcome = decide_single_gate(calibrator, reference, spec, gate, options)
    _tell(outcome)
    if outcome.verdict != "pass":
        _raise(outcome, skip)
    return outcome


def _skips(inconclusive: str) -> bool:
    if inconclusive not in ("fail", "skip"):
        raise InputError(f"{inconclusive!r} is not known", where="inconclusive", do='give "fail" or "skip"')
    return inconclusive == "skip"


def _tell(outcome: GateOutcome) -> None:
    from validation.gates.summary import summary

    (found,) = summary([outcome])["gates"]
    for listener in LISTENERS:
        listener(found)


def _raise(outcome: GateOutcome, skip: bool) -> None:
    """Raise what a verdict that is not `pass` is, in words."""
    __tracebackhide__ = True
    from unittest import SkipTest

    from reports.text.gates import advice, detectable_defect, sentence

    told = (
        f"{outcome.plan.gate.name}: {outcome.verdict}: {sentence(outcome)}",
        detectable_defect(outcome),
        advice(outcome),
    )
    message = "\n".join(told)
    if skip and outcome.verdict == "inconclusive":
        raise SkipTest(message)
    raise AssertionError(message)
