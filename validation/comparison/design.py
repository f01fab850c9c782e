"""Design of a comparison: sweep points, calibrators and seed; a point and a run number define a trial."""

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
    """A combination of swept values and the resulting scenario."""

    values: Mapping[str, Value]
    scenario: Scenario


@dataclass(frozen=True)
class Design:
    """Design of a comparison without the number of trials: small, frozen, and equal in every process.

    points : at least one, numbered from 0. candidates : calibrators in the order of tables. seed : of all randomness.
    Trial (point, run) is reproducible anywhere: random streams are keyed by (seed, run, name), so run k has equal noise
    and errors at every point, and all calibrators get an equal recording.
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
        """Design the comparison of calibrators on a scenario at every combination of swept values.

        seed : default the scenario's. Raises InputError for calibrators of equal name, a value that does not fit, and
        a scenario refused by `sim.simulation.plan`.
        """
        _check_names([one.name for one in candidates])
        seed = scenario.seed if seed is None else seed
        found = tuple(DesignPoint(values, swept(scenario, values) if values else scenario) for values in points(sweeps))
        for point in found:
            plan(point.scenario, 0, seed)
        return cls(found, tuple(candidates), seed)

    @property
    def swept(self) -> tuple[str, ...]:
        """Dotted keys of the swept values."""
        return tuple(self.points[0].values)

    @property
    def calibrators(self) -> tuple[str, ...]:
        """Row names of a trial in the order of tables, the raw measurement last; for an array `name@sensor`."""
        names = [*(one.name for one in self.candidates), UNCORRECTED]
        sensors = len(self.points[0].scenario.sensors)
        if sensors == 1:
            return tuple(names)
        return tuple(f"{name}@{sensor}" for name in names for sensor in range(1, sensors + 1))

    def identity(self) -> dict[str, Any]:
        """Return plain values that determine every trial; kept trials are valid for an equal identity only.

        Key `asked` is the calibrator's invocation for a gate file; None for an object in memory.
        """
        return {
            "format": FORMAT,
            "seed": self.seed,
            "calibrators": {one.name: {"is": repr(one), "asked": _invocation(one)} for one in self.candidates},
            "points": [{"values": dict(one.values), "scenario": as_dict(one.scenario)} for one in self.points],
            "packages": dict(self.packages),
        }

    @cached_property
    def sent(self) -> bytes:
        """The pickled design for workers; `received` unpickles and caches."""
        return pickle.dumps(self)


def _invocation(one: CalibratorEntry) -> dict[str, Any] | None:
    found = Invocation.of(one)
    return found.plain() if found else None


def _check_names(names: Sequence[str]) -> None:
    if not names:
        raise InputError("names no calibrator", where="--with", do="see `magbench list calibrators`")
    taken = [name for name, times in Counter([*names, UNCORRECTED]).items() if times > 1]
    if taken:
        do = "give each calibrator once, and a name of its own"
        raise InputError(f"the name {taken[0]} is taken", where="--with", do=do)


@lru_cache(maxsize=4)
def received(sent: bytes) -> Design:
    """Return the design sent by a process; InputError where package versions differ between the machines."""
    design: Design = pickle.loads(sent)
    here = versions()
    differing = [f"{name} {design.packages[name]} there, {here[name]} here" for name in here
                 if here[name] != design.packages[name]]  # fmt: skip
    if differing:
        do = "install the same versions on all machines"
        raise InputError(f"a worker would give other figures: {', '.join(differing)}", where="--scheduler", do=do)
    return design
