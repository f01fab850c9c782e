"""What may be known of the field, by the word that a user gives, and the information in it."""

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
"""The information in an experiment."""
PLACES: dict[str, Places] = {word: FULL if word.startswith("vector") else SYMMETRIC for word in KNOWLEDGE}
"""The entries of S that each tells."""
COLOURED = frozenset(word for word in KNOWLEDGE if "gyro" not in word)
"""Those whose bound counts noise that lasts; along a gyro white noise alone is counted."""
