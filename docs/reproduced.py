"""Tables of the page of papers: `make docs` makes them, the test run a few seeds of [Zhang2018]'s ellipsoid."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from papers.ding2021.geometry import ARRANGEMENTS, CROSS, places, reach
from papers.ding2021.geometry_rows import DISTANCES_M, dipole_error, passed_on
from papers.ding2021.trials import BASELINE_M
from papers.li2017 import flight_rows as li2017
from papers.li2017.rival_rows import EDDIES, rival_trial
from papers.li2017.rivals import RIVALS
from papers.li2017.trials import filter_trial
from papers.long2013 import flight_rows as long2013
from papers.long2013.rows import NOISE_NT
from papers.long2013.trials import LongTask, LongTrial, calibration_trial
from papers.zhang2018.trials import DRIFT_NT_H, DRIFTS, FITS, drift_trial
from papers.zhou2012 import flight_rows as zhou2012
from papers.zhou2012.trials import PRINTED, ZhouTask, bound, search_trial, stops

SEEDS = 50
"""As many as `magbench reproduce` takes, of whose medians the page speaks."""
FLOWN = 10
"""Seeds of the tables of flights and of rivals."""
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


def flown() -> list[tuple[str, ...]]:
    """A row a figure: as printed, with the paper's own motion, and flown by turntable, AUV and quadrotor; medians."""
    return [*_parameters(), *_attitudes(), _stops()]


def _parameters() -> list[tuple[str, ...]]:
    """[Li2017]: mean parameter error of the rescaled and fuzzy filter, %, with true and with measured attitude."""
    vehicles = (li2017.AUV, li2017.QUADROTOR)
    runs = {v: [li2017.flight_trial(li2017.FlightTask(v, seed)) for seed in range(FLOWN)] for v in vehicles}
    paper = [_mean_pct(filter_trial(seed)["both"].state_error_pct) for seed in range(FLOWN)]
    rows = []
    for attitude, own in ((li2017.TRUE, _median(paper)), (li2017.MEASURED, "")):
        by = [_median([_mean_pct(run[attitude, "both"].state_error_pct) for run in runs[v]]) for v in vehicles]
        rows.append((f"Li2017: parameters, {attitude}, %", "0.373", own, "", *by))
    return rows


def _mean_pct(error_pct: Any) -> float:
    return float(np.abs(error_pct).mean())


def _attitudes() -> list[tuple[str, ...]]:
    """[Long2013]: largest deviation of the strength, %, and errors of roll and pitch, degrees, in the rolling test."""
    own = [calibration_trial(LongTask(seed, NOISE_NT)) for seed in range(FLOWN)]
    runs = [long2013.flight_trial((vehicle, FLOWN)) for vehicle in long2013.VEHICLES]
    kinds = (
        ("strength, %", "2", [100 * one.worst_share for one in own], "test_pct"),
        ("roll, °", "1", _worst(own, 0), "roll_deg"),
        ("pitch, °", "2.2", _worst(own, 1), "pitch_deg"),
    )
    return [
        (f"Long2013: {what}", printed, _median(paper), *(_median([getattr(one, name) for one in run]) for run in runs))
        for what, printed, paper, name in kinds
    ]


def _worst(trials: list[LongTrial], axis: int) -> list[float]:
    return [float(np.abs(one.corrected_deg[:, axis]).max()) for one in trials]


def _stops() -> tuple[str, ...]:
    """[Zhou2012]: rms error of the worst of five direction cosines, over the bound."""
    own = [search_trial(ZhouTask(seed)).found - PRINTED for seed in range(FLOWN)]
    runs = [[zhou2012.flight_trial((v, seed)).error for seed in range(FLOWN)] for v in zhou2012.VEHICLES]
    ratios = [np.sqrt(np.mean(np.square(errors), axis=0)) / bound(stops()) for errors in (own, *runs)]
    return "Zhou2012: worst of the five, bounds", "", *(f"{ratio.max():.2g}" for ratio in ratios)


def rivals() -> list[tuple[str, ...]]:
    """A row a rival of [Li2017]: strength and worst component without eddy currents, strength with them; medians."""
    found = [rival_trial(seed) for seed in range(FLOWN)]
    without, held = EDDIES
    return [
        (
            name,
            _median([one.strength_nT[name, without] for one in found]),
            _median([float(one.component_nT[name, without].max()) for one in found]),
            _median([one.strength_nT[name, held] for one in found]),
        )
        for name in RIVALS
    ]


def arrangements() -> list[tuple[str, ...]]:
    """A row an arrangement of [Ding2021]: error of the tensor near a dipole by size, and noise passed on, s / d."""
    rows = []
    for name in ARRANGEMENTS:
        place = BASELINE_M * places(name)
        ball = place * reach(CROSS) / reach(name)
        errors = (f"{100 * dipole_error(one, DISTANCES_M[1]):.2g}" for one in (place, ball))
        rows.append((name, *errors, f"{BASELINE_M * passed_on(place):.2f}"))
    return rows


def _median(values: Sequence[float]) -> str:
    middle = float(np.median(values))
    return f"{middle:.0f}" if middle >= 100 else f"{middle:.2g}"
