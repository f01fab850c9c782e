"""A network that corrects a recording, looks at what is left, and corrects again: a solver whose judgement is learned.

The corrected field is x = (I + D)(m - o), in units of the field's strength. Two things hold of it at every sample: its
length is one, and its product with the direction of gravity a is the same d, as both are fixed in the world. Each round
solves the linearised least squares

    min over p = (o, D) of  w1 mean (|x|^2 - 1)^2 + w2 mean (x.a - d)^2 + sum ((p - mean) / std)^2

Learned are d, the mean and the standard deviation of each of the twelve parameters, and a perceptron that looks at the
moments of the recording and says w1 and w2: how far each residual is to be trusted. Where the motion tells little,
what the training runs had in common takes its place; a fit of the field's strength has neither that nor gravity.
"""

from __future__ import annotations

import torch
from torch import Tensor, nn

ROUNDS, WIDTH, PARAMETERS = 4, 32, 12
LOG_WEIGHTS = (17.0, 14.0)
LOG_STD = -3.5
"""Where learning begins: weights of 200 residuals of some thousandths, parameters of a few per cent of the strength."""
MOMENTS = 7 * 8 // 2


class Refiner(nn.Module):
    """measured (R, n, 3) in units of the strength and accel (R, n, 3) in g -> o (R, 3) and I + D (R, 3, 3).

    dip : the d to begin with.
    """

    def __init__(self, dip: float) -> None:
        super().__init__()
        self.dip = nn.Parameter(torch.tensor(dip))
        self.mean = nn.Parameter(torch.zeros(PARAMETERS))
        self.log_std = nn.Parameter(torch.full((PARAMETERS,), LOG_STD))
        self.log_weights = nn.Parameter(torch.tensor(LOG_WEIGHTS))
        self.trust = nn.Sequential(nn.Linear(MOMENTS, WIDTH), nn.Tanh(), nn.Linear(WIDTH, 2))

    def forward(self, measured: Tensor, accel: Tensor) -> tuple[Tensor, Tensor]:
        """The calibration of each recording."""
        weights = (self.log_weights + self.trust(moments(measured, accel))).exp()
        found = self.mean.expand(len(measured), PARAMETERS)
        for _ in range(ROUNDS):
            found = found + self.step(found, measured, accel, weights)
        return parted(found)

    def step(self, found: Tensor, measured: Tensor, accel: Tensor, weights: Tensor) -> Tensor:
        """The least squares' solution (R, 12), linearised about what has been found."""
        offset, matrix = parted(found)
        centred = measured - offset[:, None]
        x = centred @ matrix.mT
        precision = (-2.0 * self.log_std).exp()
        normal = torch.diag(precision).expand(len(found), PARAMETERS, PARAMETERS)
        slope = precision * (self.mean - found)
        residuals = ((x * x).sum(-1) - 1.0, (x * accel).sum(-1) - self.dip)
        for residual, direction, weight in zip(residuals, (2.0 * x, accel), weights.unbind(1), strict=True):
            rows = gradient(direction, centred, matrix)
            normal = normal + weight[:, None, None] * (rows.mT @ rows) / rows.shape[1]
            slope = slope - weight[:, None] * (rows * residual[..., None]).mean(1)
        return torch.linalg.solve(normal, slope)


def parted(parameters: Tensor) -> tuple[Tensor, Tensor]:
    """o (R, 3) and I + D (R, 3, 3) of parameters (R, 12)."""
    return parameters[:, :3], torch.eye(3) + parameters[:, 3:].reshape(-1, 3, 3)


def gradient(direction: Tensor, centred: Tensor, matrix: Tensor) -> Tensor:
    """Derivative (R, n, 12) of g.x by the parameters, g the direction: -(I + D)^T g by o, g (m - o)^T by D."""
    by_matrix = direction[..., :, None] * centred[..., None, :]
    return torch.cat([-(direction @ matrix), by_matrix.flatten(-2)], dim=-1)


def moments(measured: Tensor, accel: Tensor) -> Tensor:
    """Means (R, 28) of the products of 1, field and gravity: the recording as a set of samples."""
    z = torch.cat([torch.ones_like(measured[..., :1]), measured, accel], dim=-1)
    upper = torch.triu_indices(7, 7)
    return (z.mT @ z / z.shape[1])[:, upper[0], upper[1]]
