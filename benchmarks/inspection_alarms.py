"""False alarms of an inspection on white noise: recordings of 3000 samples that show what is not in them.

Run with ``python -m benchmarks.inspection_alarms``; the counts stand beside the numbers in `validation/policy.py`.
Recordings have three axes at 50 Hz, a constant field and white noise of 5 nT, from a converter without steps and with
steps of 5 and 15 nT, in equal parts.
"""

from __future__ import annotations

import argparse
from collections import Counter

import numpy as np

from scenarios.arrays import Array
from validation.inspection.rates import interpolation_rows
from validation.signals.faults import pile_up, repeats, spikes
from validation.signals.held import stale
from validation.signals.lattice import find_lattice, odd_share
from validation.signals.noise import block_means
from validation.signals.tones import tones

SAMPLES, INTERVAL_S, STD_NT, STEPS_NT = 3000, 0.02, 5.0, (0.0, 5.0, 15.0)
FIELD_NT = np.array([20_013.7, -11_201.2, 38_007.9])


def alarms(seed: int) -> set[str]:
    """Return names of the effects that an inspection finds in the white recording of a seed."""
    step_nT = STEPS_NT[seed % len(STEPS_NT)]
    noise_nT = np.random.default_rng(seed).normal(0, STD_NT, (SAMPLES, 3))
    mag_nT = FIELD_NT + noise_nT
    if step_nT:
        mag_nT = step_nT * np.round(mag_nT / step_nT)
    time_s = INTERVAL_S * np.arange(SAMPLES, dtype=np.float64)
    lattices = tuple(find_lattice(axis) for axis in mag_nT.T)
    means = block_means(time_s, noise_nT)
    found = {
        "frozen": bool(repeats(mag_nT).frozen),
        "full scale": bool(pile_up(mag_nT, lattices)),
        "spikes": bool(spikes(mag_nT, np.full(3, step_nT)).any()),
        "lattice": not step_nT and any(lattices),
        "preferred codes": any(
            lattice and _preferred(axis, lattice.step) for axis, lattice in zip(mag_nT.T, lattices, strict=True)
        ),
        "slow changes": any((one.excess > one.chance()).any() for one in means),
        "tones": bool(tones(time_s, noise_nT)),
        "held": stale(mag_nT),
        "interpolated": interpolation_rows(mag_nT) is not None,
    }
    return {name for name, seen in found.items() if seen}


def _preferred(axis: Array, step_nT: float) -> bool:
    share = odd_share(np.rint((axis - axis[0]) / step_nT).astype(np.int64))
    return min(share, 1 - share) < 0.5


def main() -> None:
    """Print the number of recordings with each false alarm."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--recordings", type=int, default=6000)
    count = parser.parse_args().recordings
    found = Counter(name for seed in range(count) for name in alarms(seed))
    print(f"{count} white recordings:", dict(sorted(found.items())))


if __name__ == "__main__":
    main()
