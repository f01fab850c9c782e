"""Windows of equal length over the runs of a dataset, as a lazy sequence, an array or a stream for PyTorch."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import DTypeLike, NDArray

from recordings.loading.rows import RunPlace, rows_of
from scenarios.errors import InputError
from scenarios.seeds import stream

if TYPE_CHECKING:
    from recordings.loading.torch_stream import WindowStream


@dataclass(frozen=True)
class Window:
    """A stretch of a run: values (n, c) with a column for each of the set's columns; first: its first sample."""

    run: int
    first: int
    values: NDArray[Any]


@dataclass(frozen=True, repr=False)
class WindowSet:
    """Windows of `length` samples every `stride` samples of each run; `len` and an index count windows.

    A run's last samples that fill no window are left out. Values are of the type `dtype`.

    >>> import magbench
    >>> columns = ["mag_x_nT", "mag_y_nT", "mag_z_nT"]
    >>> runs = magbench.simulate("tumble", "data", overrides=["phases.0.duration_s=60"])
    >>> windows = magbench.dataset("data", columns=columns).windows(length_s=20).astype("float32")
    >>> windows.numpy().shape, windows.shuffled(seed=1).shard(0, 1).numpy().dtype
    ((3, 200, 3), dtype('float32'))
    """

    places: tuple[RunPlace, ...]
    columns: tuple[str, ...]
    length: int
    stride: int
    dtype: DTypeLike = np.float64

    @classmethod
    def of(
        cls, places: tuple[RunPlace, ...], columns: tuple[str, ...], rate_hz: float, length_s: float, stride_s: float
    ) -> WindowSet:
        """Return the windows of runs sampled at a rate; InputError for windows shorter than a sample."""
        length, stride = round(length_s * rate_hz), round(stride_s * rate_hz)
        if length < 1 or stride < 1:
            do = f"give {1 / rate_hz:g} s or more"
            raise InputError("windows are shorter than a sample", where="length_s, stride_s", do=do)
        return cls(places, columns, length, stride)

    def __len__(self) -> int:
        return int(self._ends[-1]) if self.places else 0

    def __repr__(self) -> str:
        """Return one line: windows, samples and columns of each, runs."""
        return f"WindowSet: {len(self)} windows of {self.length} x {len(self.columns)}, {len(self.places)} runs"

    def __getitem__(self, index: int) -> Window:
        """Return a window, read now."""
        if not -len(self) <= index < len(self):
            raise IndexError(f"window {index} of {len(self)}")
        index %= len(self)
        run = int(np.searchsorted(self._ends, index, side="right"))
        first = (index - (int(self._ends[run - 1]) if run else 0)) * self.stride
        return Window(self.places[run].run, first, self._values(self.places[run], first, self.length))

    def __iter__(self) -> Iterator[Window]:
        """Yield the windows in order; each run is read once."""
        for place in self.places:
            count = self._count(place)
            if count:
                values = self._values(place, 0, (count - 1) * self.stride + self.length)
                starts = range(0, count * self.stride, self.stride)
                yield from (Window(place.run, first, values[first : first + self.length]) for first in starts)

    @property
    def runs(self) -> NDArray[np.int64]:
        """Number of the run of each window (W,)."""
        runs = np.array([place.run for place in self.places], dtype=np.int64)
        return np.repeat(runs, np.diff(self._ends, prepend=0))

    def numpy(self) -> NDArray[Any]:
        """Return all windows (W, n, c)."""
        out = np.empty((len(self), self.length, len(self.columns)), self.dtype)
        for row, window in zip(out, self, strict=True):
            row[:] = window.values
        return out

    def astype(self, dtype: DTypeLike) -> WindowSet:
        """Return the windows with values of a different type, such as float32."""
        return replace(self, dtype=dtype)

    def shard(self, index: int, count: int) -> WindowSet:
        """Return part `index` of `count` parts of equal size: neighbouring runs, so that a file is read once."""
        if not 0 <= index < count:
            raise InputError(f"part {index} of {count}", where="shard", do="give an index from 0 to count - 1")
        bounds = [len(self.places) * k // count for k in (index, index + 1)]
        return replace(self, places=self.places[bounds[0] : bounds[1]])

    def torch(self, *, targets: dict[str, NDArray[Any]] | None = None, shuffle_seed: int | None = None) -> WindowStream:
        """Return a PyTorch IterableDataset of {"values": (n, c), "run", "targets": (k,)}, shared out among workers.

        targets : k arrays (R,) by name, values of each run, such as of `RunSet.parameters`; without them no "targets".
        shuffle_seed : draws the order of the runs. Raises InputError where torch is not installed.
        """
        try:
            from recordings.loading.torch_stream import WindowStream
        except ImportError:
            do = "pip install 'magbench[learn]', or use numpy()"
            raise InputError("needs the package torch", where="torch()", do=do) from None
        known = targets or {}
        if any(len(values) != len(self.places) for values in known.values()):
            raise InputError("has not one value a run", where="targets", do="take them from the same set's parameters")
        table = np.array([np.asarray(values, np.float64) for values in known.values()]).T
        by_run = {place.run: row for place, row in zip(self.places, table, strict=True)} if known else {}
        return WindowStream(self if shuffle_seed is None else self.shuffled(shuffle_seed), by_run)

    def shuffled(self, seed: int) -> WindowSet:
        """Return the windows with the runs in an order drawn by `seed`; each run's windows stay in order."""
        order = stream(seed, 0, "window order").permutation(len(self.places))
        return replace(self, places=tuple(self.places[k] for k in order))

    @cached_property
    def _ends(self) -> NDArray[np.int64]:
        """Number of windows up to the end of each run."""
        return np.cumsum([self._count(place) for place in self.places], dtype=np.int64)

    def _count(self, place: RunPlace) -> int:
        return max(0, (place.rows - self.length) // self.stride + 1)

    def _values(self, place: RunPlace, first: int, rows: int) -> NDArray[Any]:
        part = replace(place, first=place.first + first, rows=rows)
        return columns_together(part, self.columns, self.dtype)


def columns_together(place: RunPlace, columns: Sequence[str], dtype: DTypeLike) -> NDArray[Any]:
    """Return columns of some rows as one array (n, c)."""
    named = rows_of(place, columns)
    out = np.empty((place.rows, len(columns)), dtype)
    for column, name in zip(out.T, columns, strict=True):
        column[:] = named[name]
    return out
