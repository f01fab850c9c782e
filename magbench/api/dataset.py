"""`magbench.dataset`."""

from __future__ import annotations

from collections.abc import Sequence
from os import PathLike, fspath
from typing import TYPE_CHECKING

from magbench.api.inputs import in_keywords

if TYPE_CHECKING:
    from recordings.loading import RunSet


@in_keywords()
def dataset(path: str | PathLike[str], *, columns: Sequence[str] | None = None, check: bool = True) -> RunSet:
    """The runs of a dataset for learning and statistics, read as they are used.

    path : directory, or a URL such as `s3://bucket/data`. columns : which to read, in this order; by default all.
    check : whether each file is compared with its SHA-256 in `dataset.json` before its first read; this reads the file
    once, at about 1.7 GB/s of CPU.

    `len` and an index count runs; `.windows(length_s=, stride_s=)` cuts them, `.split(train=0.8, seed=0)` parts them by
    run, `.numpy()` reads them whole, `.windows(...).torch()` feeds a DataLoader, `.parameters` has the true parameters.
    Raises InputError for a directory without a complete dataset, for unknown columns, and for a file that differs.

    >>> import magbench
    >>> made = magbench.simulate("tumble", "data", runs=3, overrides=["phases.0.duration_s=60"])
    >>> runs = magbench.dataset("data", columns=["mag_x_nT", "mag_y_nT", "mag_z_nT"])
    >>> len(runs), len(runs.windows(length_s=10))
    (3, 18)
    >>> [len(part) for part in runs.split(train=0.67, seed=0)]
    [2, 1]
    """
    from recordings.loading import load_dataset
    from recordings.url_path import place_at

    return load_dataset(place_at(fspath(path)), columns, check=check)
