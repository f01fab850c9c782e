"""Windows as a PyTorch IterableDataset; the only place that imports torch, when `WindowSet.torch` is called."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from typing import Any, Protocol

import numpy as np
import torch
from numpy.typing import NDArray
from torch.utils.data import IterableDataset, get_worker_info


class Shareable(Protocol):
    """Windows that are shared out in parts; each has `run` and `values`."""

    def __len__(self) -> int: ...

    def shard(self, index: int, count: int) -> Iterable[Any]:
        """Return part `index` of `count` parts."""


class WindowStream(IterableDataset):  # type: ignore[misc]
    """The windows of a set in order; each worker of a DataLoader reads its own share of the runs.

    targets : run -> values (k,), which come with each of its windows; empty for none.
    """

    def __init__(self, windows: Shareable, targets: Mapping[int, NDArray[np.float64]]) -> None:
        super().__init__()
        self.windows, self.targets = windows, targets

    def __len__(self) -> int:
        return len(self.windows)

    def __iter__(self) -> Iterator[dict[str, Any]]:
        """Yield the windows of this worker's share."""
        worker = get_worker_info()
        which = (0, 1) if worker is None else (worker.id, worker.num_workers)
        for window in self.windows.shard(*which):
            target = {"targets": torch.as_tensor(self.targets[window.run])} if self.targets else {}
            yield {"values": torch.as_tensor(window.values), "run": window.run, **target}
