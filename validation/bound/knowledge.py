"""Knowledge of the field by user option, and functions for the Fisher information."""

from __future__ import annotations

from collections.abc import Callable

from validation.bound.experiment import Experiment
from validation.bound.information import (
    FULL,
    SYMMETRIC,
    Information,
    Places,
    norm,
    norm_and_gyro,
    vector,
    vector_and_eddy,
)
from validation.bound.levelled import WORD, norm_gyro_and_accel

KNOWLEDGE: dict[str, Callable[[Experiment], Information]] = {
    "norm": norm,
    "norm+gyro": norm_and_gyro,
    WORD: norm_gyro_and_accel,
    "vector": vector,
    "vector+eddy": vector_and_eddy,
}
"""Functions for the Fisher information of an experiment."""
PLACES: dict[str, Places] = {word: FULL if word.startswith("vector") else SYMMETRIC for word in KNOWLEDGE}
"""Entries of S that each knowledge determines."""
COLOURED = frozenset(word for word in KNOWLEDGE if "gyro" not in word)
"""Knowledge with bounds for coloured noise; with a gyro only white noise is supported."""
