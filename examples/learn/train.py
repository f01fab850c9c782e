"""Trains the network on a split dataset and sets it beside `ellipsoid` on the runs that neither has seen.

magbench simulate examples/learn/circles.toml -o out/circles --runs 600 --split 80/10/10
python -m examples.learn.train out/circles
"""

from __future__ import annotations

import argparse
import copy
from pathlib import Path

import torch
from torch import Tensor

from examples.learn.data import Runs, read_part
from examples.learn.judge import compared, told
from examples.learn.network import Refiner

EPOCHS, BATCH = 40, 40
RATE, DECAY = 2e-2, 1e-4


def main() -> None:
    """Read, train, judge."""
    asked = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    asked.add_argument("dataset", type=Path)
    asked.add_argument("--epochs", type=int, default=EPOCHS)
    asked.add_argument("--seed", type=int, default=0)
    options = asked.parse_args()
    network = trained(options.dataset, options.epochs, options.seed)
    print(told(compared(options.dataset, network)))


def trained(out: Path, epochs: int = EPOCHS, seed: int = 0) -> Refiner:
    """The network after the epoch that is best on the validation part; each epoch deals the irons anew."""
    torch.manual_seed(seed)
    torch.set_default_dtype(torch.float64)
    dealer = torch.Generator().manual_seed(seed)
    train, validation = read_part(out, "train"), read_part(out, "validation")
    network, best, least = Refiner(train.dip), {}, float("inf")
    optimiser = torch.optim.AdamW(network.parameters(), lr=RATE, weight_decay=DECAY)
    pace = torch.optim.lr_scheduler.OneCycleLR(optimiser, RATE, total_steps=epochs * (1 + (len(train) - 1) // BATCH))
    for epoch in range(epochs):
        network.train()
        runs = train.with_irons_dealt_anew(dealer)
        for rows in torch.randperm(len(runs), generator=dealer).split(BATCH):
            optimiser.zero_grad()
            loss(network, runs.some(rows)).backward()
            optimiser.step()
            pace.step()
        seen = validated(network, validation)
        if seen < least:
            least, best = seen, copy.deepcopy(network.state_dict())
        if epoch % 10 == 0 or epoch == epochs - 1:
            print(f"epoch {epoch}: typical error {seen:.0f} nT on the validation part", flush=True)
    network.load_state_dict(best)
    return network.eval()


def loss(network: Refiner, runs: Runs) -> Tensor:
    """Mean logarithm of the error: a run that tells much counts as much as one that tells little."""
    return error(runs, *network(runs.measured, runs.accel)).log().mean()


def error(runs: Runs, offset: Tensor, matrix: Tensor) -> Tensor:
    """Rms (R,) over all attitudes and axes of M (S h + b - o) - h, for fields h of length one."""
    turned = matrix @ runs.S - torch.eye(3)
    shifted = (matrix @ (runs.b - offset)[..., None])[..., 0]
    return ((turned.square().sum((1, 2)) / 3 + shifted.square().sum(1)) / 3).sqrt()


def validated(network: Refiner, runs: Runs) -> float:
    """The loss on the runs as they are, as an error in nT."""
    network.eval()
    with torch.no_grad():
        return float((loss(network, runs).exp() * runs.strength_nT.mean()).item())


if __name__ == "__main__":
    main()
