"""A part of a split dataset as tensors, and other irons on the same motions."""

from __future__ import annotations

from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
import pandas as pd
import torch
from torch import Tensor

G_M_S2 = 9.81
SAMPLES = 200
"""Samples of each run that the network sees, evenly spread over it."""
XYZ = "xyz"
COLUMNS = {
    "noise": [f"effect_white_noise_{a}_nT" for a in XYZ],
    "field": [f"true_field_{a}_nT" for a in XYZ],
    "measured": [f"mag_{a}_nT" for a in XYZ],
    "accel": [f"accel_{a}_m_s2" for a in XYZ],
}
IRON = [f"effects.soft_iron.matrix.{row}.{column}" for row in range(3) for column in range(3)]
OFFSET = [f"effects.hard_iron.offset_nT.{axis}" for axis in range(3)]
FIELD = [f"field.enu_nT.{axis}" for axis in range(3)]


@dataclass(frozen=True)
class Runs:
    """R runs of n samples. Fields are in units of the Earth's field's strength, so that all numbers are about one.

    number (R,); measured, field, noise, accel (R, n, 3), accel in g; S (R, 3, 3) and b (R, 3) of m = S h + b + noise;
    strength_nT (R,).
    """

    number: Tensor
    measured: Tensor
    field: Tensor
    noise: Tensor
    accel: Tensor
    S: Tensor
    b: Tensor
    strength_nT: Tensor

    def __len__(self) -> int:
        return len(self.number)

    @property
    def dip(self) -> float:
        """Mean product of the true field and gravity, both about one in length."""
        return float((self.field * self.accel).sum(-1).mean())

    def with_irons_dealt_anew(self, dealer: torch.Generator) -> Runs:
        """Each run's motion and noise with the iron of another: the labels make as many runs as there are pairs."""
        order = torch.randperm(len(self), generator=dealer)
        S, b = self.S[order], self.b[order]
        return replace(self, S=S, b=b, measured=self.field @ S.mT + b[:, None] + self.noise)

    def some(self, rows: Tensor) -> Runs:
        """The runs in these rows."""
        return Runs(**{name: values[rows] for name, values in vars(self).items()})


def read_part(out: Path, part: str) -> Runs:
    """The runs of a part of the dataset, with the iron that `runs.parquet` tells of each."""
    wanted = ["run", *(name for names in COLUMNS.values() for name in names)]
    frame = pd.read_parquet(out / "data" / part, columns=wanted)
    samples = [thinned(rows) for _, rows in frame.groupby("run", sort=True)]
    runs = pd.read_parquet(out / "runs.parquet").set_index("run").loc[sorted(frame["run"].unique())]
    strength_nT = np.linalg.norm(runs[FIELD].to_numpy(), axis=1)
    columns = {name: np.stack([rows[names].to_numpy() for rows in samples]) for name, names in COLUMNS.items()}
    units = dict.fromkeys(columns, strength_nT[:, None, None]) | {"accel": G_M_S2}
    tensors = {name: tensor(values / units[name]) for name, values in columns.items()}
    return Runs(
        number=torch.tensor(runs.index.to_numpy()),
        S=tensor(np.eye(3) + runs[IRON].to_numpy().reshape(-1, 3, 3)),
        b=tensor(runs[OFFSET].to_numpy() / strength_nT[:, None]),
        strength_nT=tensor(strength_nT),
        **tensors,
    )


def thinned(rows: pd.DataFrame) -> pd.DataFrame:
    """SAMPLES of a run, evenly spread over it."""
    return rows.iloc[np.linspace(0, len(rows) - 1, SAMPLES).round().astype(int)]


def tensor(values: np.ndarray) -> Tensor:
    """Double precision: the normal equations of level circles are nearly singular."""
    return torch.tensor(values, dtype=torch.float64)
