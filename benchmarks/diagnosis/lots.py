"""Wrong names of three recordings together, cheaply: recordings of a pool are diagnosed once, lots drawn from it.

    python -m benchmarks.diagnosis.lots --first 24 --pools 50 -o out/lots

A pool has twelve short recordings of one vehicle: three plain, three coloured, three of each of two truths that are
drawn for it. Its lots share recordings, but no two the same three. What two or more of a lot have may be named, and
nothing else. Tuning seeds; trials land as they end, and the same command goes on where it was stopped.
"""

from __future__ import annotations

import argparse
import json
import time
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import lru_cache
from pathlib import Path
from typing import Any

import numpy as np

from benchmarks.diagnosis.outside import OUTSIDE
from benchmarks.diagnosis.resumed import resumed
from benchmarks.diagnosis.three import (
    COLOURS,
    FLIGHTS,
    SHORT_TRANSFERS,
    STRENGTHS,
    WANDERS,
    Three,
    flight,
    rightly_named,
)
from benchmarks.diagnosis.truth import BASE, EQUIVALENT
from diagnosis.problem.formulation import pose_model
from diagnosis.result import EvidenceKind, Transfer
from diagnosis.several.selection import PooledRecording, select_pooled
from diagnosis.several.workflow import judge_pool
from diagnosis.workflow import examine
from sim.scenario import ModelSpec

POOLS_SEED = 1_000_000
"""Noise and cuts of the pools begin here: none of them is that of another bench's recording."""
EACH = 3
"""Recordings of a pool with the same truth."""
MIXED = ("ppc", "pcc", "App", "Acc", "Apc", "Bpp", "Bcc", "Bpc", "ABp", "ABc", "AAp", "AAc", "BBp", "BBc", "AAB", "ABB")
"""Lots of recordings that differ in what they hide: plain, coloured, the one and the other truth."""
ALIKE = ("ppp", "ccc", "AAA", "BBB")
TURNS = {"attitude_misalignment"} | EQUIVALENT["attitude_misalignment"]
"""Names of a field that is turned against what it should be."""
Row = dict[str, Any]


@dataclass(frozen=True)
class VehiclePool:
    """Twelve recordings of a vehicle."""

    seed: int

    @property
    def truths(self) -> dict[str, tuple[str, str, float]]:
        """Kind, what is hidden and its strength, by letter."""
        rng = np.random.default_rng([self.seed, 19])
        strengths = [float(rng.choice(STRENGTHS["same"])) for _ in "AB"]
        one = str(rng.choice([*SHORT_TRANSFERS, *OUTSIDE]))
        others = [name for name in (*SHORT_TRANSFERS, *OUTSIDE) if not _alike(one, name)]
        two = str(rng.choice(others))
        colour = str(rng.choice(COLOURS))
        made = {"p": ("null", "", 0.0), "c": ("coloured", colour, 0.0)}
        return made | {
            letter: ("outside" if name in OUTSIDE else "same", name, strength)
            for letter, name, strength in zip("AB", (one, two), strengths, strict=True)
        }

    @property
    def vehicle(self) -> str:
        """One after the other."""
        return sorted(FLIGHTS)[self.seed % len(FLIGHTS)]

    def trial(self, letter: str) -> Three:
        """The recordings of a truth, as a lot of three."""
        kind, hidden, strength = self.truths[letter]
        seed = POOLS_SEED + 4 * self.seed + "pcAB".index(letter)
        return Three(kind, self.vehicle, hidden, strength, seed, short=True)

    @property
    def lots(self) -> Iterator[str]:
        """Letters and numbers of the recordings of every lot."""
        rng = np.random.default_rng([self.seed, 20])
        for letters in (*ALIKE, *MIXED):
            chosen = {one: rng.permutation(EACH)[: letters.count(one)] for one in dict.fromkeys(letters)}
            yield "".join(f"{one}{i}" for one, several in chosen.items() for i in sorted(several))


def _alike(one: str, other: str) -> bool:
    return one == other or other in EQUIVALENT.get(one, set()) or one in EQUIVALENT.get(other, set())


@lru_cache(maxsize=4 * EACH)
def member_of(pool: VehiclePool, letter: str, i: int) -> PooledRecording:
    """A recording of a pool with its own diagnosis."""
    recording, field_enu_nT = flight(pool.trial(letter), i)
    model = ModelSpec.model_validate({"effects": BASE, "field": {"enu_nT": field_enu_nT.tolist()}})
    return PooledRecording.of(examine(pose_model(recording, model, None, None), model))


def run_lot(pool: VehiclePool, lot: str) -> Row:
    """What three recordings say together, without the words and models of each."""
    begun = time.process_time()
    members = [member_of(pool, letter, int(i)) for letter, i in zip(lot[::2], lot[1::2], strict=True)]
    ready = time.process_time()
    verdict, common, _ = judge_pool(members, select_pooled(members, lambda what: None)[0])
    names = [
        [one.name, *one.named.alternatives, *one.named.rivals, str(one.transfer), str(one.named.kind)] for one in common
    ]
    return {
        "key": f"{pool.seed}/{lot}", "vehicle": pool.vehicle, "truths": pool.truths, "verdict": str(verdict),
        "names": names, "cpu_s": [ready - begun, time.process_time() - ready],
    }  # fmt: skip


def wrong(row: Row) -> list[str]:
    """Names that stand without what two recordings of the lot hide; their iron differs by what has a mean there.

    Where coefficients differ each may hide another of the class that is named. An attitude that walks has a mean error,
    as another recording may have by what it hides.
    """
    seed, lot = row["key"].split("/")
    truths = VehiclePool(int(seed)).truths
    hides = {letter: rightly_named(kind, hidden) for letter, (kind, hidden, _) in truths.items()}
    shared, disturbed = _shared(lot, truths, hides), lot.count("A") + lot.count("B") > 1

    def is_right(name: str, *others: str) -> bool:
        differ, how = Transfer.NOT_TRANSFERRED in others, others[-1]
        each = sum(lot.count(letter) for letter, names in hides.items() if names & {name, *others})
        return bool(shared & {name, *others}) or (differ and each > 1) or (disturbed and how == EvidenceKind.IRON)

    return [one[0] for one in row["names"] if not is_right(*one)]


def _shared(lot: str, truths: dict[str, tuple[str, str, float]], hides: dict[str, set[str]]) -> set[str]:
    """Names that are right for two recordings of a lot at least."""
    shared = set().union(*(names for letter, names in hides.items() if lot.count(letter) > 1))
    turned = (letter for letter, (_, hidden, _) in truths.items() if hidden in (*WANDERS, *TURNS))
    return shared | TURNS if sum(map(lot.count, turned)) > 1 else shared


def figures(rows: Sequence[Row]) -> dict[str, Any]:
    """Lots and wrong names by what their recordings hide."""
    kinds: dict[str, list[bool]] = {}
    for row in rows:
        kinds.setdefault(row["key"].split("/")[1][::2], []).append(bool(wrong(row)))
    return {
        "lots": len(rows),
        "wrong": sum(map(sum, kinds.values())),
        "by kind": {kind: [len(some), sum(some)] for kind, some in kinds.items()},
        "which": [(row["key"], row["truths"], row["names"]) for row in rows if wrong(row)],
    }


def main() -> None:
    """Run the lots that are not in the log yet, and print their figures."""
    parser = argparse.ArgumentParser(prog="python -m benchmarks.diagnosis.lots")
    parser.add_argument("--first", type=int, default=0)
    parser.add_argument("--pools", type=int, default=25)
    parser.add_argument("-o", "--out", type=Path, default=Path("out/lots"))
    given = parser.parse_args()
    wanted = [
        (pool, lot) for pool in map(VehiclePool, range(given.first, given.first + given.pools)) for lot in pool.lots
    ]
    rows = resumed(wanted, given.out, lambda one: run_lot(*one), lambda one: f"{one[0].seed}/{one[1]}")
    print(json.dumps(figures(rows), indent=1))


if __name__ == "__main__":
    main()
