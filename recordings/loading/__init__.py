"""Datasets as arrays, for learning and statistics: runs, windows, splits and true parameters, read as they are used."""

from __future__ import annotations

from recordings.loading.runs import LoadedRun, RunSet, load_dataset
from recordings.loading.windows import Window, WindowSet

__all__ = ["LoadedRun", "RunSet", "Window", "WindowSet", "load_dataset"]
