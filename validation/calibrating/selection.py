"""Calibrators selected by name, module:object, command or Python object."""

from __future__ import annotations

import re
from collections.abc import Sequence

from calib import CALIBRATORS, Reference, get
from calib.external import external_method
from calib.models.inputs import input_groups
from calib.options import SEPARATOR
from recordings import Recording
from scenarios.errors import InputError
from scenarios.names import closest, offered_calibrators
from validation.calibrating.calibrator_entry import BuiltIn, CalibratorEntry, FitMethod
from validation.calibrating.external_command import PLACEHOLDER, parse_command
from validation.calibrating.object_process import process_of
from validation.calibrating.processes import TIME_LIMIT_S
from validation.calibrating.python_object import ImportedObject, default_name
from validation.calibrating.registry import REGISTERED, RegisteredObject

USUAL, LEVEL, DRIVEN = ("sphere", "ellipsoid"), "planar", "motor_ellipsoid"
"""Calibrators of a motion about all axes, of a level turn, and beside currents, commands or a temperature."""
OBJECT = re.compile(r"(?:([A-Za-z][\w.-]*)=)?([A-Za-z_][\w.]*:[A-Za-z_][\w.]*)")
"""`module:object`, or `NAME=module:object`."""


def select_calibrators(
    with_: Sequence[str], exec_: Sequence[str] = (), time_limit_s: float = TIME_LIMIT_S
) -> tuple[CalibratorEntry, ...]:
    """Return the calibrators named on a command line, in order and without repetition.

    with_ : names of `magbench list calibrators`, also with options `NAME:OPTION=VALUE:...` (a name before the colon
    comes before a module), `module:object`, `NAME=module:object`. exec_ : commands, see
    `external_command.parse_command`. time_limit_s : time allowed for one fit of a calibrator that is not magbench's.

    Raises InputError for an unknown name, an object that is no calibrator, and two calibrators of equal name.
    """
    entries = [_by_text(text, time_limit_s) for text in dict.fromkeys(with_)]
    for text in dict.fromkeys(exec_):
        program = parse_command(text, time_limit_s)
        attitude_free = not (program.uses_vector or "attitude" in program.needs)
        entries.append(CalibratorEntry(program.name, program, attitude_free, needs=program.needs))
    names = [entry.name for entry in entries]
    twice = [name for name in names if names.count(name) > 1]
    if twice:
        do = "rename one of them: NAME=module:object, or --exec 'NAME=...'"
        raise InputError(f"two calibrators are called {twice[0]!r}", where="--with", do=do)
    return tuple(entries)


def calibrators_of_scenario(names: Sequence[str], time_limit_s: float = TIME_LIMIT_S) -> tuple[CalibratorEntry, ...]:
    """Return the calibrators that a scenario names; InputError as `select_calibrators`, and for module:object.

    A scenario is data, whoever wrote it: only a user's own option runs a module of the working directory.
    """
    known = known_names()
    own = next((text for text in names if text.partition(SEPARATOR)[0] not in known and OBJECT.fullmatch(text)), None)
    if own is not None:
        what = f"{own!r} is a module's object, and a scenario imports none"
        raise InputError(what, where="calibrators", do=f"give --with {own}")
    return select_calibrators(names, (), time_limit_s)


def usual_calibrators(recording: Recording, reference: Reference) -> tuple[CalibratorEntry, ...]:
    """Return the calibrators where none is named: USUAL; planar alone for two axes.

    With planar for a level turn, and with DRIVEN where a logged current, command or temperature varies: of several
    motors by the sum of their currents, since currents of each follow the vehicle's turns.
    """
    if recording.origin.axes == "xy":
        return select_calibrators([LEVEL])
    level = recording.array_mag_nT is None and get(LEVEL).fit(recording, reference).status.kind != "not_applicable"
    return select_calibrators([*USUAL, *([LEVEL] if level else []), *_driven(recording)])


def _driven(recording: Recording) -> list[str]:
    """Return the calibrator beside inputs that vary; none where the one power input is each motor's."""
    kinds = [one.kind for one in input_groups(recording) if one.varies]
    several = "motors" in kinds or "outputs" in kinds
    single = next((kind for kind in ("battery", "throttle") if kind in kinds), "none")
    if not kinds or (several and single == "none" and "temperature" not in kinds):
        return []
    return [f"{DRIVEN}:{single}" if several else DRIVEN]


def select_calibrator(found: object, time_limit_s: float = TIME_LIMIT_S) -> CalibratorEntry:
    """Return one calibrator given as a --with text, as a command with placeholders, or as a Python object.

    Raises InputError as `select_calibrators`, and for an object that is no calibrator.
    """
    if isinstance(found, str):
        named, commands = ((), (found,)) if PLACEHOLDER.search(found) else ((found,), ())
        (entry,) = select_calibrators(named, commands, time_limit_s)
        return entry
    name = str(getattr(found, "name", None) or getattr(found, "__name__", None) or type(found).__name__)
    method = external_method(found, name)
    return _entry(name, RegisteredObject(name, method), method)


def known_names() -> dict[str, str]:
    """Return every name that --with accepts with a one-line summary: built-in, of packages, registered here."""
    own = {name: cls.summary for name, cls in CALIBRATORS.items()}
    offered = {name: f"of an installed package: {spec}" for name, spec in offered_calibrators().items()}
    here = dict.fromkeys(REGISTERED, "registered in this process")
    return offered | here | own


def _by_text(text: str, time_limit_s: float) -> CalibratorEntry:
    """Return the calibrator of a --with text: a built-in name with its options, a registered name, module:object."""
    if text.partition(SEPARATOR)[0] in CALIBRATORS:
        return _entry(text, BuiltIn(text), get(text))
    if text in REGISTERED:
        return _entry(text, RegisteredObject(text, REGISTERED[text]), REGISTERED[text])
    offered = offered_calibrators()
    given = OBJECT.fullmatch(offered.get(text, text))
    if given is None:
        names = known_names()
        do = closest(text, names, most=len(names)) + "; one of your own: module:object"
        raise InputError(f"no calibrator is called {text!r}", where="--with", do=do)
    name = text if text in offered else given[1] or default_name(given[2])
    facts = process_of(given[2]).facts()
    return _entry(name, ImportedObject(name, given[2], time_limit_s, facts.sha256), facts)


def _entry(name: str, method: FitMethod, facts: object) -> CalibratorEntry:
    """Return the entry with the facts declared by a class, a function, or the process of an imported object."""
    needs = tuple(getattr(facts, "needs", ()))
    whole_array, eddy = (bool(getattr(facts, fact, False)) for fact in ("whole_array", "eddy"))
    return CalibratorEntry(name, method, "attitude" not in needs, whole_array=whole_array, eddy=eddy, needs=needs)
