"""Anybody's calibrator: a description that can be sent to another process, and that fits there."""

from __future__ import annotations

import re
import time
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

import calib
from calib import CALIBRATORS, Calibration, Reference
from calib.outside import outside
from recordings import Recording
from scenarios.errors import InputError
from scenarios.names import closest, offered_calibrators
from validation.calibrating.command import PLACEHOLDER, command
from validation.calibrating.fit import FitMethod, Fitted, failed, timed
from validation.calibrating.host import host
from validation.calibrating.processes import TIME_LIMIT_S
from validation.calibrating.python_object import Imported
from validation.calibrating.registry import REGISTERED, InThisProcess

OBJECT = re.compile(r"(?:([A-Za-z][\w.-]*)=)?([A-Za-z_][\w.]*:[A-Za-z_][\w.]*)")
"""`module:object`, or `NAME=module:object`."""


@dataclass(frozen=True)
class CalibratorEntry:
    """A calibrator that takes part: small, frozen, and the same in every process.

    `attitude_free`: it uses no attitude, so that its scores leave out the rotation which the field's strength cannot
    tell. `whole_array`: it takes all sensors of an array at once. `eddy`: it finds eddy currents too. `needs`: what it
    needs of a recording, keys of NEEDS.
    """

    name: str
    method: FitMethod
    attitude_free: bool
    whole_array: bool = False
    eddy: bool = False
    needs: tuple[str, ...] = ()

    def fit(self, recording: Recording, reference: Reference, rng: np.random.Generator | None = None) -> Calibration:
        """The calibration of one recording; as `timed`."""
        return self.timed(recording, reference, rng).calibration

    def timed(self, recording: Recording, reference: Reference, rng: np.random.Generator | None = None) -> Fitted:
        """The calibration and its processor time; rng (default: seed 0) matters to stochastic methods only.

        Whatever a calibrator raises becomes its status, not converged, with the message as the reason.
        """
        start_s = time.process_time()
        try:
            return self.method.fit(recording, reference, rng or np.random.default_rng(0))
        except InputError as error:
            reason = str(error)
        except Exception as error:
            reason = f"{type(error).__name__}: {error}"
        return Fitted(failed(self.name, reason), time.process_time() - start_s)


@dataclass(frozen=True)
class BuiltIn:
    """One of `calib.CALIBRATORS`, with its default settings."""

    name: str

    def fit(self, recording: Recording, reference: Reference, rng: np.random.Generator) -> Fitted:
        """The calibration of one recording, in this process."""
        return timed(lambda: calib.get(self.name).fit(recording, reference, rng))


def candidates(
    with_: Sequence[str], exec_: Sequence[str] = (), time_limit_s: float = TIME_LIMIT_S
) -> tuple[CalibratorEntry, ...]:
    """The calibrators that texts name, one of each.

    with_ : names of `magbench list calibrators`, `module:object`, `NAME=module:object`. exec_ : commands, as
    `command.command` takes them. time_limit_s : what a fit of those that are not magbench's may take.

    Raises InputError for what is not there, what is no calibrator, and two of the same name.
    """
    found = [_named(text, time_limit_s) for text in dict.fromkeys(with_)]
    for text in dict.fromkeys(exec_):
        program = command(text, time_limit_s)
        attitude_free = not (program.uses_vector or "attitude" in program.needs)
        found.append(CalibratorEntry(program.name, program, attitude_free, needs=program.needs))
    names = [candidate.name for candidate in found]
    twice = [name for name in names if names.count(name) > 1]
    if twice:
        do = "call one of them otherwise: NAME=module:object, or --exec 'NAME=...'"
        raise InputError(f"two calibrators are called {twice[0]!r}", where="--with", do=do)
    return tuple(found)


def candidate(found: object, time_limit_s: float = TIME_LIMIT_S) -> CalibratorEntry:
    """One calibrator of whatever form: a text for --with, a command with its placeholders, or an object in memory.

    Raises InputError as `candidates`, and for an object that is no calibrator.
    """
    if isinstance(found, str):
        named, commands = ((), (found,)) if PLACEHOLDER.search(found) else ((found,), ())
        (one,) = candidates(named, commands, time_limit_s)
        return one
    called = getattr(found, "name", None) or getattr(found, "__name__", None) or type(found).__name__
    method = outside(found, str(called))
    return _candidate(str(called), InThisProcess(str(called), method), method)


def known_names() -> dict[str, str]:
    """What `--with` takes by name, with a line each: magbench's own, those of packages, those registered here."""
    own = {name: cls.summary for name, cls in CALIBRATORS.items()}
    offered = {name: f"of an installed package: {spec}" for name, spec in offered_calibrators().items()}
    here = dict.fromkeys(REGISTERED, "registered in this process")
    return offered | here | own


def _named(text: str, time_limit_s: float) -> CalibratorEntry:
    if text in CALIBRATORS:
        return _candidate(text, BuiltIn(text), CALIBRATORS[text])
    if text in REGISTERED:
        return _candidate(text, InThisProcess(text, REGISTERED[text]), REGISTERED[text])
    offered = offered_calibrators()
    given = OBJECT.fullmatch(offered.get(text, text))
    if given is None:
        names = known_names()
        do = closest(text, names, most=len(names)) + "; one of your own: module:object"
        raise InputError(f"no calibrator is called {text!r}", where="--with", do=do)
    name = text if text in offered else given[1] or own_name(given[2])
    facts = host(given[2]).facts()
    return _candidate(name, Imported(name, given[2], time_limit_s, facts.sha256), facts)


def own_name(spec: str) -> str:
    """What module:object is called where nothing else is said."""
    return spec.partition(":")[2].rpartition(".")[2]


def _candidate(name: str, method: FitMethod, facts: object) -> CalibratorEntry:
    """A candidate by what its class, its function or its module's process says of it."""
    needs = tuple(getattr(facts, "needs", ()))
    whole_array, eddy = (bool(getattr(facts, fact, False)) for fact in ("whole_array", "eddy"))
    return CalibratorEntry(name, method, "attitude" not in needs, whole_array=whole_array, eddy=eddy, needs=needs)
