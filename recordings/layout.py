"""Where a dataset's runs lie: the file of each run, in folders of bounded size."""

from __future__ import annotations

from dataclasses import dataclass

from recordings.split import Split

DATA = "data"
"""Directory of a split dataset's files, and of nothing else, so that other readers can open the directory whole."""
FILES_PER_FOLDER = 10_000
"""Files of a folder; directories of more are slow on network file systems."""
MOST_FILES = 100_000
"""Files of a dataset: the manifest lists each, and is read whole."""


@dataclass(frozen=True)
class DatasetFile:
    """A file of a dataset: its path relative to the dataset, with "/", and its runs in order."""

    path: str
    runs: tuple[int, ...]

    @property
    def first(self) -> int:
        """The number of the first run, which names the file."""
        return self.runs[0]


@dataclass(frozen=True)
class DatasetLayout:
    """The files of a dataset; a run's file depends on the number of the run alone, so a growing dataset moves none.

    split : puts each run into the directory of its part. runs_per_file : runs of the same part that share a file.
    The first FILES_PER_FOLDER files of a part lie in its directory, the next in the subfolder `10000`, and so on.
    """

    split: Split | None = None
    runs_per_file: int = 1

    @property
    def numbered(self) -> bool:
        """Whether each row has the number of its run: files of several runs, or files that are read together."""
        return self.split is not None or self.runs_per_file > 1

    def file_of(self, run: int, runs: int | None = None) -> DatasetFile:
        """Return the file of a run, in a dataset of `runs` runs; by default with every run that the file may hold."""
        part = None if self.split is None else self.split.part_of(run)
        return self._file(part, self._index(run) // self.runs_per_file, runs)

    def count(self, runs: int) -> int:
        """Return the number of files of a dataset of `runs` runs."""
        return sum(-(-held // self.runs_per_file) for held in self._parts(runs).values())

    def files(self, runs: int) -> list[DatasetFile]:
        """Return the files of a dataset of `runs` runs, in the order of their first runs."""
        counts = [(part, -(-held // self.runs_per_file)) for part, held in self._parts(runs).items()]
        found = (self._file(part, number, runs) for part, count in counts for number in range(count))
        return sorted(found, key=lambda file: file.first)

    def pattern(self, part: str, runs: int) -> str:
        """Return the pattern of the files of a part, relative to the dataset."""
        files = -(-self._parts(runs)[part] // self.runs_per_file)
        return f"{DATA}/{part}/{'**/' if files > FILES_PER_FOLDER else ''}*.parquet"

    def folders(self, runs: int) -> tuple[str, ...]:
        """Return the directories of the files, relative to the dataset, in order of appearance."""
        return tuple(dict.fromkeys(file.path.rpartition("/")[0] for file in self.files(runs)))

    def _parts(self, runs: int) -> dict[str | None, int]:
        """Return the number of runs of each part; all runs under None without a split."""
        counts: dict[str | None, int] = {None: runs}
        return counts if self.split is None else dict(self.split.counts(runs).items())

    def _index(self, run: int) -> int:
        """Return how many runs of the same part come before a run."""
        return run if self.split is None else self.split.index_of(run)

    def _file(self, part: str | None, number: int, runs: int | None) -> DatasetFile:
        """Return file `number` of a part."""
        indices = range(number * self.runs_per_file, (number + 1) * self.runs_per_file)
        held = tuple(indices if self.split is None or part is None else (self.split.run_of(part, k) for k in indices))
        there = held if runs is None else tuple(run for run in held if run < runs)
        return DatasetFile(self._path(part, number, held[0]), there)

    def _path(self, part: str | None, number: int, first: int) -> str:
        shard = number // FILES_PER_FOLDER * FILES_PER_FOLDER
        name = f"run-{first:05d}.parquet" if self.runs_per_file == 1 else f"runs-{first:05d}.parquet"
        return "/".join([*([DATA, part] if part else []), *([str(shard)] if shard else []), name])
