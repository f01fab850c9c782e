"""The table of [Zhang2018]'s ellipsoid in the page of papers; the test run makes a few of its seeds."""

from __future__ import annotations

import numpy as np

from papers.zhang2018.trials import DRIFT_NT_H, DRIFTS, FITS, drift_trial

SEEDS = 50
"""As many as `magbench reproduce` takes, of whose medians the page speaks."""
FEW = 3
"""Seeds that the test run makes again, to see whether the page is older than the program."""


def rms_nT(seeds: int) -> dict[str, list[list[float]]]:
    """Rms of |h| - F over the record in nT: by fit a row of each drift's for every seed."""
    trials = [drift_trial(seed) for seed in range(seeds)]
    return {fit: [list(trial.rms_nT[fit]) for trial in trials] for fit in FITS}


def ellipsoid() -> list[tuple[str, ...]]:
    """A row a drift: its size in nT/h and the median rms of each fit."""
    medians = [np.median(values, axis=0) for values in rms_nT(SEEDS).values()]
    return [
        (f"{times * DRIFT_NT_H:.3g}", *(f"{median[i]:.1f}" for median in medians)) for i, times in enumerate(DRIFTS)
    ]
