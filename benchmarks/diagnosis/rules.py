"""The rules of the diagnosis, each with what it does when it is off, so that its effect can be measured.

A rule is a function or a method somewhere in `diagnosis`. `watched` counts the calls in which each rule had a say;
with `off` a rule answers as if it did not exist.
"""

from __future__ import annotations

import functools
import importlib
from collections import Counter
from collections.abc import Callable, Iterator, Mapping
from contextlib import ExitStack, contextmanager
from dataclasses import dataclass
from typing import Any
from unittest.mock import patch

import numpy as np

Neutral = Callable[..., Any]
"""(the rule itself, its arguments) -> its answer when it is off."""


@dataclass(frozen=True)
class Rule:
    """A rule: the place of its function, ``module:name``, and its answer when it is off."""

    place: str
    neutral: Neutral

    @property
    def name(self) -> str:
        """The function, with its class, behind the last part of its module."""
        module, _, path = self.place.partition(":")
        return f"{module.rpartition('.')[2]}.{path}"


def answer(value: Any) -> Neutral:
    """The same answer to everything."""
    return lambda rule, *args, **named: value


def argument(i: int) -> Neutral:
    """An argument as it came."""
    return lambda rule, *args, **named: args[i]


def first_of(i: int, *rest: Any) -> Neutral:
    """An argument as it came, ahead of further values."""
    return lambda rule, *args, **named: (args[i], *rest)


NOTHING: Mapping[str, Mapping[str, Neutral]] = {
    "workflow": {
        "correct_reference": argument(0),
        "held_rows": lambda rule, problem: np.zeros(len(problem.recording), bool),
        "find_start_samples": lambda rule, problem: np.zeros(len(problem.recording), bool),
        "better_channels": answer(None),
        "follow_channels": answer(None),
    },
    "decision.second_passes": {
        "refit_iron": argument(0),
        "rejected_if_worse": argument(0),
        "without_dip": answer(()),
        "attitude_in_time": answer(()),
        "without_stated_effect": answer(()),
        "in_noise_left": answer(()),
    },
    "decision.selection": {
        "within_stated_errors": answer(value=False),
        "split_by_motor": argument(0),
        "rank_windowed": answer([]),
        "first_form_evidence": answer(()),
        "find_pulsations": answer(()),
        "_with_look_alike": argument(0),
        "_grows_with_time": answer(value=False),
        "_is_form_of_accepted": answer(value=False),
        "_differs_by_setting": answer(value=False),
        "is_form_by_size": answer(value=False),
        "_refit_settings": lambda rule, chosen, accepted, candidates, start: list(accepted),
        "_with_form_owner": argument(0),
        "_without_superseded": argument(0),
    },
    "decision.forms": {
        "_best_form": answer(None),
        "_drop_unsupported_forms": lambda rule, accepted, start: list(accepted),
        "_refined_settings": argument(1),
    },
    "decision.coloured_choice": {
        "_stronger_in_window": answer([]),
        "CandidateTest.is_accepted_with_another": answer(value=False),
        "CandidateTest._refusal_in_colour": answer(()),
        "CandidateTest._refusal_along_the_field": answer(()),
        "CandidateTest._refusal_by_wander": answer(()),
        "explains_along_field": answer(value=True),
        "attitude_suffices": answer(value=False),
        "wander_wins": answer(value=False),
        "is_channel_equivalent": answer(value=False),
    },
    "evidence.rivals": {
        "lobe_of_the_heading": answer(()),
        "wave_of_the_field": answer(()),
        "size_that_follows": answer(()),
        "size_of_each_part": answer(()),
        "course_of_time": answer(()),
        "course_of_the_field": answer(()),
        "course_of_the_place": answer(()),
    },
    "evidence.candidate_test": {
        "ColouredBaseline.surrogate_gains": answer(np.zeros(1)),
        "gain_within": answer(0.0),
        "added_share": answer(1.0),
    },
    "decision.choice": {
        "_select_in_family": lambda rule, family, policy: max(family, key=lambda one: one.gain),
    },
    "evidence.held_out": {"_at_own_size": argument(1), "search_price": answer(0.0), "refine_listed": argument(1)},
    "evidence.windowed_candidates": {"_is_one_sided": answer(value=False), "_is_a_jump": answer(value=False)},
    "evidence.binned_rows": {"BinnedRows.refine_folds": argument(0)},
    "evidence.hypothesis": {"Hypothesis._with_best_wander": argument(0)},
    "library.candidates": {"Candidate.is_natural": answer(value=True), "as_iron_sees": argument(0)},
    "problem.formulation": {"without_their_noise": argument(0)},
    "evidence.direct": {
        "_rounded": answer(None),
        "_clipped": answer(None),
        "_held": answer(None),
        "_wrong_values": answer(None),
        "_across_the_field": answer(value=False),
        "find_burst_peaks": lambda rule, problem: np.zeros(problem.recording.mag_nT.shape, bool),
    },
    "decision.conclusion": {
        "find_slow_noise": answer(None),
        "is_form_error": answer(value=False),
        "iron_changes": answer(((), ())),
        "beyond_wander": lambda rule, iron, *rest: tuple(iron),
        "_beats_coloured_noise": answer(value=True),
        "_is_conventional": answer(value=False),
        "_is_negligible": answer(value=False),
        "absorbed_effects": answer(()),
    },
    "evidence.slow_noise": {
        "is_attitude_error": answer(value=False),
        "is_earth_frame_noise": answer(value=False),
        "follows_time_only": answer(value=True),
        "is_random": answer(value=True),
        "_refitted": argument(0),
    },
    "decision.monotone_courses": {"similar_motors": answer(()), "similar_channels": answer(())},
    "decision.verdict_rules": {
        "gap_is_larger": answer(()),
        "field_turns_too_fast": answer(()),
        "part_of_swept_tone": answer(()),
        "channel_in_residual": answer(()),
        "motion_in_residual": answer(()),
        "iron_follows_a_channel": answer(()),
        "_explains_some": answer(value=True),
        "_only_iron_with_rivals": answer(value=False),
        "_may_be_one_channel": answer(value=False),
    },
    "repair.named_effects": {"missing_white_noise": answer(None), "with_rival_channels": argument(1)},
    "evidence.residual_tests": {"_rises": answer(value=False)},
}
"""By module of `diagnosis`: what each rule answers when it is off."""
RULES = {
    rule.name: rule
    for module, rules in NOTHING.items()
    for rule in (Rule(f"diagnosis.{module}:{name}", neutral) for name, neutral in rules.items())
}


@contextmanager
def watched(off: str = "") -> Iterator[Counter[str]]:
    """Count, by name, the calls in which a rule's answer was another than when it is off; one of them may be off."""
    count: Counter[str] = Counter()
    with ExitStack() as patches:
        for rule in RULES.values():
            patches.enter_context(_patched(rule, count, off=rule.name == off))
        yield count


def _patched(rule: Rule, count: Counter[str], *, off: bool) -> Any:
    """The patch that counts a rule's answers, or gives those it has when it is off."""
    module, _, path = rule.place.partition(":")
    owner: Any = importlib.import_module(module)
    *classes, attribute = path.split(".")
    for name in classes:
        owner = getattr(owner, name)
    own = getattr(owner, attribute)

    @functools.wraps(own)
    def asked(*args: Any, **named: Any) -> Any:
        without = rule.neutral(own, *args, **named)
        if off:
            return without
        found = own(*args, **named)
        found = tuple(found) if isinstance(found, Iterator) else found
        count[rule.name] += not _same(found, without)
        return found

    table = _table_with(owner, own)
    if table is not None:  # a rule that is listed in a table is called through the table
        return patch.object(owner, table, _replaced(getattr(owner, table), own, asked))
    return patch.object(owner, attribute, asked)


def _table_with(owner: Any, own: Any) -> str | None:
    """Name of the module's tuple that lists a function, by itself or in a pair."""
    return next((name for name, value in vars(owner).items() if name.isupper() and _lists(value, own)), None)


def _lists(value: Any, own: Any) -> bool:
    return isinstance(value, tuple) and any(one is own or (isinstance(one, tuple) and own in one) for one in value)


def _replaced(table: tuple[Any, ...], own: Any, asked: Any) -> tuple[Any, ...]:
    """The table with the watched function in place of the own one."""
    return tuple(
        _replaced(one, own, asked) if isinstance(one, tuple) else asked if one is own else one for one in table
    )


def _same(found: Any, without: Any) -> bool:
    if found is without:
        return True
    if isinstance(found, np.ndarray) or isinstance(without, np.ndarray):
        return np.array_equal(found, without)
    if isinstance(found, list | tuple) and isinstance(without, list | tuple):
        return len(found) == len(without) and all(map(_same, found, without))
    try:
        return bool(type(found) is type(without) and found == without)
    except ValueError:  # dataclasses that hold arrays
        return False
