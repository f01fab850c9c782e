"""A dataset's runs as a lazy sequence, with subsets by run and the true parameters of each."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property, lru_cache
from typing import Any, overload

import numpy as np
import pyarrow as pa
from numpy.typing import NDArray

from recordings.description.runs import FIXED, RUNS, flattened
from recordings.loading.rows import Rows, RunPlace, check_file, file_rows, rows_of
from recordings.loading.windows import WindowSet
from recordings.manifest import MANIFEST, Manifest, read_manifest
from recordings.metadata import RunFile, file_runs
from recordings.readers import verified_table
from recordings.url_path import Place
from scenarios.errors import InputError
from scenarios.seeds import stream

PHASE = "phase"
ANEW = "repeat the `simulate` command: it writes the table anew"
Parameter = float | str | bool | None


@dataclass(frozen=True)
class LoadedRun:
    """A run: number, columns (n,) by name, and the true parameters by the keys of a scenario file."""

    run: int
    columns: Rows
    parameters: dict[str, Parameter]


@dataclass(frozen=True, repr=False)
class RunSet:
    """Runs of a dataset, read as they are used; `len`, an index and a slice count runs in order of their numbers.

    places : where each run lies. columns : what is read.

    >>> import magbench
    >>> runs = magbench.simulate("tumble", "data", runs=3, overrides=["phases.0.duration_s=60"])
    >>> learn, hold_out = runs.split(train=0.67, seed=0)
    >>> len(learn), len(hold_out), runs.numpy()["mag_x_nT"].shape
    (2, 1, (1800,))
    >>> runs.windows(length_s=20, stride_s=10).runs.tolist()
    [0, 0, 0, 0, 0, 1, 1, 1, 1, 1, 2, 2, 2, 2, 2]
    """

    path: Place
    manifest: Manifest
    places: tuple[RunPlace, ...]
    columns: tuple[str, ...]

    def __len__(self) -> int:
        return len(self.places)

    def __repr__(self) -> str:
        """Return one line: runs, samples and columns."""
        samples = sum(place.rows for place in self.places)
        runs = "1 run" if len(self) == 1 else f"{len(self)} runs"
        return f"RunSet: {runs}, {samples} samples, {len(self.columns)} columns of {self.path}"

    @overload
    def __getitem__(self, index: int) -> LoadedRun: ...
    @overload
    def __getitem__(self, index: slice) -> RunSet: ...
    def __getitem__(self, index: int | slice) -> LoadedRun | RunSet:
        """Return a run, read now, or the runs of a slice."""
        if isinstance(index, slice):
            return replace(self, places=self.places[index])
        place = self.places[index]
        return LoadedRun(place.run, rows_of(place, self.columns), self._parameters_of(place))

    def __iter__(self) -> Iterator[LoadedRun]:
        return (self[index] for index in range(len(self)))

    @property
    def runs(self) -> NDArray[np.int64]:
        """Numbers of the runs (R,)."""
        return np.array([place.run for place in self.places], dtype=np.int64)

    @cached_property
    def parameters(self) -> dict[str, NDArray[Any]]:
        """True parameters and drawn values of every run: key -> (R,), NaN or None where a run lacks one."""
        if self.manifest.layout.numbered:
            return _tabled(self.path / RUNS, self.runs)
        told = [self._parameters_of(place) for place in self.places]
        keys = dict.fromkeys(key for one in told for key in one)
        return {key: _cells([one.get(key) for one in told]) for key in keys}

    def part(self, name: str) -> RunSet:
        """Return the runs of `train`, `validation` or `test` of a dataset simulated with --split."""
        split = self.manifest.split
        if split is None:
            raise InputError("the dataset has no parts", where=str(self.path), do="use split(train=0.8)")
        return replace(self, places=tuple(place for place in self.places if split.part_of(place.run) == name))

    def split(self, train: float = 0.8, seed: int = 0) -> tuple[RunSet, RunSet]:
        """Return two sets, a share `train` of the runs drawn by `seed`, and the others; no run is in both."""
        if not 0.0 <= train <= 1.0:
            raise InputError(f"{train} is no share", where="train", do="give a number from 0 to 1")
        drawn = stream(seed, 0, "dataset split").permutation(len(self))[: round(train * len(self))]
        chosen = np.isin(np.arange(len(self)), drawn)
        first, rest = ([self.places[k] for k in np.flatnonzero(which)] for which in (chosen, ~chosen))
        return replace(self, places=tuple(first)), replace(self, places=tuple(rest))

    def windows(self, *, length_s: float, stride_s: float | None = None) -> WindowSet:
        """Return stretches of `length_s`, one every `stride_s` (by default end to end), each within one run."""
        numbers = tuple(name for name in self.columns if name != PHASE)
        return WindowSet.of(self.places, numbers, self._rate_hz, length_s, stride_s or length_s)

    def numpy(self) -> Rows:
        """Return the columns of all runs, one after the other, and `run`, the number of each row's run; each (N,)."""
        runs = np.repeat(self.runs, [place.rows for place in self.places])
        numbers = {name: np.empty(len(runs)) for name in self.columns if name != PHASE}
        words, done = [], 0
        for places in _by_file(self.places):
            piece = self._piece(places)
            rows = sum(place.rows for place in places)
            for name, values in numbers.items():
                values[done : done + rows] = piece[name]
            words.append(piece.get(PHASE, np.empty(0, str)))
            done += rows
        every = {"run": runs, **numbers, PHASE: np.concatenate(words) if words else np.empty(0, str)}
        return {name: every[name] for name in ("run", *self.columns)}

    @property
    def _rate_hz(self) -> float:
        if "sampling.rate_hz" in self.manifest.scenario.get("vary", {}):
            do = "cut the windows from single runs"
            raise InputError("the rate differs from run to run", where=str(self.path), do=do)
        return float(self.manifest.scenario["sampling"]["rate_hz"])

    def _piece(self, places: Sequence[RunPlace]) -> Rows:
        """Return the rows of neighbouring runs of one file, at once where they are the whole file."""
        joined = replace(places[0], rows=sum(place.rows for place in places))
        if (joined.first, joined.rows) == (0, self._lengths[joined.file]):
            return file_rows(joined, self.columns)
        return rows_of(joined, self.columns)

    @cached_property
    def _lengths(self) -> dict[Place, int]:
        """Samples of each file."""
        return {self.path / file.path: file.rows for file in self.manifest.files}

    def _parameters_of(self, place: RunPlace) -> dict[str, Parameter]:
        check_file(place)
        held = _parameters(place.file, place.run if self.manifest.runs_per_file == 1 else None)
        if place.run not in held:
            raise InputError(f"holds no run {place.run}", where=str(place.file), do=ANEW)
        return held[place.run]


def load_dataset(path: Place, columns: Sequence[str] | None = None, *, check: bool = True) -> RunSet:
    """Open a complete dataset; nothing but its manifest and, of files of several runs, its table of runs is read.

    columns : which to read, in this order; by default all. check : whether each file is compared with its SHA-256 in
    the manifest before its first read. Raises InputError for an incomplete dataset and for columns that it lacks.
    """
    manifest = read_manifest(path)
    if not manifest.complete:
        raise InputError("is not complete", where=str(path), do="repeat the `simulate` command: it resumes")
    known = [column.name for column in manifest.columns]
    unknown = [name for name in columns or () if name not in known]
    if unknown:
        raise InputError(f"has no column {unknown[0]!r}", where=str(path), do=f"it has {', '.join(known[:12])}, …")
    sha256 = {file.path: file.sha256 if check else None for file in manifest.files}
    places = sorted(_places(path, manifest, sha256), key=lambda place: place.run)
    return RunSet(path, manifest, tuple(places), tuple(known if columns is None else columns))


def _places(path: Place, manifest: Manifest, sha256: Mapping[str, str | None]) -> Iterator[RunPlace]:
    """Yield where each run lies, in the order of the files; sha256 : by the paths that the manifest lists."""
    if manifest.runs_per_file == 1:
        for file in manifest.files:
            yield RunPlace(file.run, path / file.path, 0, file.rows, sha256[file.path])
        return
    first, last, there = 0, "", path
    for run, listed, rows in _listed(path / RUNS, manifest):
        if listed != last:
            first, last, there = 0, listed, path / listed
        yield RunPlace(run, there, first, rows, sha256[listed])
        first += rows


def _listed(table: Place, manifest: Manifest) -> list[tuple[int, str, int]]:
    """Return number, file and samples of each run by the table of runs; InputError where the manifest has others."""
    held = (_table(table, ["run", "file", "rows"]).column(name).to_pylist() for name in ("run", "file", "rows"))
    found = list(zip(*held, strict=True))
    files = {file.path: file.rows for file in manifest.files}
    samples = dict.fromkeys(files, 0)
    for _, file, rows in found:
        samples[file] = samples.get(file, 0) + rows
    whole = sorted(run for run, _, _ in found) == list(range(manifest.runs)) and all(rows > 0 for *_, rows in found)
    if samples != files or not whole:
        raise InputError(f"lists other runs than {MANIFEST}", where=str(table), do=ANEW)
    return found


def _table(path: Place, columns: Sequence[str] | None = None) -> pa.Table:
    """Return the table of runs; InputError for a damaged one, and for columns of other types."""
    table = verified_table(path, columns)
    for name in ("run", "file", "rows"):
        field = table.schema.field(name) if name in table.column_names else None
        if field is None or field.type != FIXED[name][0] or table.column(name).null_count:
            raise InputError(f"has no column {name} of {FIXED[name][0]}", where=str(path), do=ANEW)
    return table


@lru_cache(4)
def _parameters(file: Place, run: int | None) -> dict[int, dict[str, Parameter]]:
    """Return the true parameters of the runs in a file; run : that of a file of one run."""
    entry = RunFile(-1 if run is None else run, file.name, 0, 0, "")
    return {held.run: dict(flattened(held.parameters)) for held in file_runs(file, entry)}


def _tabled(path: Place, runs: NDArray[np.int64]) -> dict[str, NDArray[Any]]:
    """Return the parameters of some runs in the table of runs."""
    table = _table(path)
    order = np.argsort(table.column("run").to_numpy())
    rows = table.take(order[np.searchsorted(table.column("run").to_numpy()[order], runs)])
    return {name: rows.column(name).to_numpy() for name in rows.column_names if name not in FIXED}


def _by_file(places: Sequence[RunPlace]) -> Iterator[list[RunPlace]]:
    """Yield runs that lie one after the other in one file together."""
    held: list[RunPlace] = []
    for place in places:
        if held and (place.file, place.first) != (held[-1].file, held[-1].first + held[-1].rows):
            yield held
            held = []
        held.append(place)
    if held:
        yield held


def _cells(values: Sequence[Parameter]) -> NDArray[Any]:
    """Return numbers as float64 with NaN for None, anything else as objects."""
    numbers = all(value is None or isinstance(value, float) for value in values)
    return np.array(values, dtype=np.float64 if numbers else object)
