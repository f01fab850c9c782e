"""The network and `ellipsoid` on the test part, by the bench's own scores."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pandas as pd
import torch

from calib import CALIBRATORS, Calibration, Reference, Status
from examples.learn.data import read_part
from examples.learn.network import Refiner
from recordings import read_run
from sim.effects import build
from validation.scoring.hold_out import Environment, hold_out
from validation.scoring.scores import score

AMPLITUDES = ["phases.0.roll_amplitude_deg", "phases.0.pitch_amplitude_deg"]
EXCITED_DEG = (5.0, 10.0, 15.0)
"""Where the rows of the table end: the rms of the amplitudes of roll and pitch."""
SCORES = ("offset_error", "matrix_error", "holdout_sphere_component_rms", "heading_rms")


def compared(out: Path, network: Refiner) -> pd.DataFrame:
    """A row for every test run and method: its scores, its status, and how far the vehicle rolled and pitched.

    Both are scored as methods without attitude: the rotation that fits best is taken out before.
    """
    table = pd.read_parquet(out / "runs.parquet").set_index("run")
    rows = []
    for run, learned in calibrations(out, network).items():
        recording, truth = read_run(out, run=run)
        field_nT = truth.parameters["field_enu_nT"]
        effects = build(truth.parameters["effects"][0], truth.parameters["effect_order"], "run")
        known = hold_out(effects, Environment.of(recording, field_nT))
        fitted = CALIBRATORS["ellipsoid"]().fit(recording, Reference.of_vector(tuple(field_nT)))
        excited_deg = float(np.sqrt(np.mean(np.square(table.loc[run, AMPLITUDES].to_numpy(float)))))
        for found in (learned, fitted):
            scores = {one.name: one.value for one in score(found, recording, known, attitude_free=True)}
            told_of = {name: scores.get(name, np.inf) for name in SCORES}
            rows.append({"run": run, "excited_deg": excited_deg, "method": found.name, **told_of})
    return pd.DataFrame(rows)


def calibrations(out: Path, network: Refiner) -> dict[int, Calibration]:
    """What the network says of every test run."""
    runs = read_part(out, "test")
    with torch.no_grad():
        offsets, matrices = network(runs.measured, runs.accel)
    offsets_nT = (offsets * runs.strength_nT[:, None]).double().numpy()
    return {
        int(number): Calibration(name="learned", status=Status("ok"), offset_nT=offset_nT, matrix=matrix)
        for number, offset_nT, matrix in zip(runs.number, offsets_nT, matrices.double().numpy(), strict=True)
    }


def told(scores: pd.DataFrame) -> str:
    """Medians by method and excitation, and in how many runs the network is nearer to the truth."""
    ends = [0.0, *EXCITED_DEG, np.inf]
    part = pd.cut(scores["excited_deg"], ends, right=False).rename("roll and pitch, deg")
    medians = scores.groupby([part, "method"], observed=True)[list(SCORES)].median()
    by = scores.pivot(index="run", columns="method", values="holdout_sphere_component_rms")
    better = int((by["learned"] < by["ellipsoid"]).sum())
    return f"{medians.round(3).to_string()}\nthe network is better in {better} of {len(by)} runs"
