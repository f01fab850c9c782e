"""What is compared: points of a sweep, calibrators and a seed; with a run's number that is a whole trial."""

from __future__ import annotations

import pickle
from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property, lru_cache
from typing import Any

from recordings.resume import versions
from scenarios.errors import InputError
from scenarios.sweep import Sweep, Value, points, swept
from scenarios.toml import as_dict
from sim.scenario import Scenario
from sim.simulation import plan
from validation.calibrating.calibrator_entry import CalibratorEntry
from validation.calibrating.invocation import Invocation
from validation.scoring.evaluation import UNCORRECTED

FORMAT = 2


@dataclass(frozen=True)
class DesignPoint:
    """One combination of the swept values, and the scenario with them."""

    values: Mapping[str, Value]
    scenario: Scenario


@dataclass(frozen=True)
class Design:
    """A comparison without its number of trials: small, frozen, and the same in every process.

    points : at least one, numbered from 0; candidates : in the order of tables; seed : of all randomness.
    Trial (point, run) is the same whoever computes it: its random streams are keyed by (seed, run, name), so that at
    every point run k has the same noise and errors, and every candidate the same recording.
    """

    points: tuple[DesignPoint, ...]
    candidates: tuple[CalibratorEntry, ...]
    seed: int
    packages: Mapping[str, str] = field(default_factory=lambda: versions())

    @classmethod
    def of(
        cls,
        scenario: Scenario,
        candidates: Sequence[CalibratorEntry],
        sweeps: Sequence[Sweep] = (),
        seed: int | None = None,
    ) -> Design:
        """The comparison of candidates on a scenario, at every combination of the swept values.

        seed : default the scenario's. Raises InputError for candidates of one name, a value that does not fit, and
        what `sim.simulation.plan` refuses.
        """
        _check_names([one.name for one in candidates])
        seed = scenario.seed if seed is None else seed
        found = tuple(DesignPoint(values, swept(scenario, values) if values else scenario) for values in points(sweeps))
        for point in found:
            plan(point.scenario, 0, seed)
        return cls(found, tuple(candidates), seed)

    @property
    def swept(self) -> tuple[str, ...]:
        """The dotted keys that the points differ in."""
        return tuple(self.points[0].values)

    @property
    def calibrators(self) -> tuple[str, ...]:
        """Rows of a trial in the order of tables, the raw measurement's last; of an array `name@sensor`."""
        names = [*(one.name for one in self.candidates), UNCORRECTED]
        sensors = len(self.points[0].scenario.sensors)
        if sensors == 1:
            return tuple(names)
        return tuple(f"{name}@{sensor}" for name in names for sensor in range(1, sensors + 1))

    def identity(self) -> dict[str, Any]:
        """What decides every figure of every trial, as plain values: a kept trial holds for the same identity alone.

        `asked` is how a calibrator is named again, in a file of gates; None of one in memory.
        """
        return {
            "format": FORMAT,
            "seed": self.seed,
            "calibrators": {one.name: {"is": repr(one), "asked": _asked(one)} for one in self.candidates},
            "points": [{"values": dict(one.values), "scenario": as_dict(one.scenario)} for one in self.points],
            "packages": dict(self.packages),
        }

    @cached_property
    def sent(self) -> bytes:
        """The design as it goes to a worker, which `received` unpacks once."""
        return pickle.dumps(self)


def _asked(one: CalibratorEntry) -> dict[str, Any] | None:
    asked = Invocation.of(one)
    return asked.plain() if asked else None


def _check_names(names: Sequence[str]) -> None:
    if not names:
        raise InputError("names no calibrator", where="--with", do="see `magbench list calibrators`")
    taken = [name for name, times in Counter([*names, UNCORRECTED]).items() if times > 1]
    if taken:
        do = "give each calibrator once, and a name of its own"
        raise InputError(f"the name {taken[0]} is taken", where="--with", do=do)


@lru_cache(maxsize=4)
def received(sent: bytes) -> Design:
    """The design that another process sent; InputError where it has other versions of what decides the numbers."""
    design: Design = pickle.loads(sent)
    here = versions()
    differing = [f"{name} {design.packages[name]} there, {here[name]} here" for name in here
                 if here[name] != design.packages[name]]  # fmt: skip
    if differing:
        do = "install the same versions on all machines"
        raise InputError(f"a worker would give other figures: {', '.join(differing)}", where="--scheduler", do=do)
    return design
