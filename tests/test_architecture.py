"""The rules that keep the architecture: who imports whom, how long a function is, where a name is written."""

from __future__ import annotations

import ast
import inspect
import subprocess
from pathlib import Path, PurePosixPath

import pytest

from sim.effects import EFFECTS
from sim.vehicles import VEHICLES
from tests.conftest import ROOT
from tests.imports import FILES, ORDER, circle, graph, imported, name_of, nodes, rooms
from tests.measure import complexities, functions

FLOORS = (
    {"signals"},
    {"axes"},
    {"screening"},
    {"scoring", "calibrating", "inspection", "cross_validation"},
    {"bound", "comparison", "rechecking", "known_figures"},
    {"gates", "planning"},
    {"assessment"},
)
"""The rooms of `validation`: numbers below, judgement above them."""
SHARED = {"__init__.py", "policy.py", "text.py"}
"""What any room of `validation` may use."""
MOST_TOKENS, MOST_COMPLEXITY = 300, 10

WORDS = {
    "validation/rechecking/old_claim.py": {"scale"},
    "validation/rechecking/parts.py": {"scale"},
    "papers/ding2021/rows.py": {"scale", "misalignment"},
    "validation/inspection/frames.py": {"scale"},
    "validation/inspection/values.py": {"spikes"},
    "recordings/units.py": {"scale"},
    "recordings/column_words.py": {"scale"},
    "sim/effects/channels.py": {"scale"},
    "scenarios/paths/turntable.py": {"turntable"},
}
"""Where the word is a quantity's, a factor's, a fault's or a phase's and no effect or vehicle is meant."""


def package_of(path: Path) -> str:
    return path.relative_to(ROOT).parts[0]


def test_a_package_imports_only_from_its_left() -> None:
    """And `calib` not from `sim`, which stands beside it."""
    wrong = [
        (name_of(path), name)
        for path in FILES
        for name in imported(path)
        if name.split(".")[0] in ORDER and name.split(".")[0] not in allowed_in(package_of(path))
    ]
    assert not wrong


def allowed_in(package: str) -> set[str]:
    """The packages that a package may import."""
    return set(ORDER[: ORDER.index(package) + 1]) - ({"sim"} if package == "calib" else set())


def test_no_room_is_over_a_quarter_of_the_product() -> None:
    lines = dict.fromkeys(ORDER, 0)
    for path in FILES:
        lines[package_of(path)] += len(path.read_text(encoding="utf-8").splitlines())
    room, most = max(lines.items(), key=lambda item: item[1])
    assert most <= sum(lines.values()) / 4, room


def test_no_two_classes_have_one_name() -> None:
    names: dict[str, list[str]] = {}
    for path in FILES:
        for node in nodes(path):
            if isinstance(node, ast.ClassDef):
                names.setdefault(node.name, []).append(name_of(path))
    assert not {name: places for name, places in names.items() if len(places) > 1}


def test_no_file_imports_itself_by_a_circle() -> None:
    found = circle(graph())
    assert not found, " -> ".join(found)


def test_no_folder_imports_itself_by_a_circle() -> None:
    """In each folder the files and folders in it, each taken whole, stand on floors."""
    folders = {str(parent) for name in graph() for parent in PurePosixPath(name).parents}
    assert not {folder: found for folder in sorted(folders) if (found := circle(rooms(folder)))}


def test_every_room_of_validation_uses_only_rooms_below_it() -> None:
    floor = {room: number for number, rooms_there in enumerate(FLOORS) for room in rooms_there}
    used = {room: names - SHARED for room, names in rooms("validation").items() if room not in SHARED}
    assert set(used) <= set(floor), "a new room needs its floor in FLOORS"
    upward = [(room, name) for room, names in used.items() for name in names if floor[name] > floor[room]]
    assert not upward


def test_no_room_of_validation_is_over_a_third_of_it() -> None:
    lines: dict[str, int] = {}
    for path in FILES:
        parts = path.relative_to(ROOT).parts
        if parts[0] == "validation":
            lines[parts[1]] = lines.get(parts[1], 0) + len(path.read_text(encoding="utf-8").splitlines())
    room, most = max(lines.items(), key=lambda item: item[1])
    assert most <= sum(lines.values()) / 3, room


def test_no_function_is_long_or_tangled() -> None:
    paths = [*FILES, *(ROOT / "benchmarks").rglob("*.py"), *(ROOT / "docs").glob("*.py")]
    found = [function for path in paths for function in functions(path, MOST_TOKENS)]
    assert not [one for one in found if one.tokens > MOST_TOKENS or one.complexity > MOST_COMPLEXITY]
    tested = [(name, found) for path in (ROOT / "tests").rglob("*.py") for name, found in complexities(path)]
    assert not [name for name, complexity in tested if complexity > MOST_COMPLEXITY]


def test_an_effect_and_a_vehicle_are_named_only_at_home() -> None:
    """As a text of its own, outside the file that defines it; the catalogue, tests, docs and benchmarks may.

    A calibrator knows of neither: where it says "scale", that is a parameter of its own.
    """
    homes = {cls.name: Path(inspect.getfile(cls)) for cls in EFFECTS} | dict.fromkeys(VEHICLES)
    found: dict[str, set[str]] = {}
    for path in [path for path in FILES if package_of(path) != "calib"]:
        texts = {node.value for node in nodes(path) if isinstance(node, ast.Constant)}
        away = {name for name in texts & homes.keys() if not _at_home(path, name, homes[name])}
        if away - WORDS.get(name_of(path), set()):
            found[name_of(path)] = away - WORDS.get(name_of(path), set())
    assert not found


def _at_home(path: Path, name: str, home: Path | None) -> bool:
    """In the effect's file, or for a vehicle in `sim/vehicles`."""
    return path == home if home else path.parent == ROOT / "sim" / "vehicles"


def test_the_diagnosis_imports_no_effect_by_name() -> None:
    """Effects are selected by what their class says: clues, roles, stage."""
    names = {cls.__name__ for cls in EFFECTS}
    found = {
        name_of(path): sorted(used)
        for path in FILES
        if package_of(path) == "diagnosis" and (used := {one.split(".")[-1] for one in imported(path)} & names)
    }
    assert not found


def test_a_calibrator_cannot_name_the_truth() -> None:
    """Of the recordings it sees their type and the names of channels; the truth beside a simulated one is another."""
    paths = (ROOT / "calib").rglob("*.py")
    seen = {name for path in paths for name in imported(path) if name.split(".")[0] == "recordings"}
    assert {name for name in seen if not name.startswith("recordings.channels.")} <= {"recordings.Recording"}


@pytest.mark.parametrize(
    ("library", "home"),
    [
        ("mujoco", lambda p: package_of(p) == "sim"),
        ("rerun", lambda p: (ROOT / "reports" / "viewer") in p.parents),
        ("matplotlib", lambda p: (ROOT / "reports" / "plots") in p.parents),
        ("filterpy", lambda p: package_of(p) == "calib"),
    ],
)
def test_a_library_is_used_in_its_one_place(library: str, home) -> None:  # type: ignore[no-untyped-def]
    users = [path for path in FILES if any(name.split(".")[0] == library for name in imported(path))]
    assert not [str(path) for path in users if not home(path)]


def test_no_address_of_a_registry_and_no_path_of_a_machine() -> None:
    tracked = subprocess.run(["git", "ls-files"], cwd=ROOT, capture_output=True, text=True)
    if tracked.returncode:
        pytest.skip("not a git checkout")
    marks = ("index-" + "url", "/ro" + "ot/", "/ho" + "me/", "/wo" + "rk/", "pypi" + ".org")
    texts = {name: (ROOT / name) for name in tracked.stdout.split()}
    found = [
        (name, mark)
        for name, path in texts.items()
        if path.suffix in {".py", ".toml", ".txt", ".md", ".xml", ".html", ""} and path.is_file()
        for mark in marks
        if mark in path.read_text(encoding="utf-8", errors="replace")
    ]
    assert not found
