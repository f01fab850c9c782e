"""Pools of short recordings: what their lots are drawn from, and which names count as wrong."""

from __future__ import annotations

from collections import Counter
from typing import Any

import pytest

from benchmarks.diagnosis.lots import EACH, VehiclePool, figures, wrong
from benchmarks.diagnosis.truth import EQUIVALENT
from diagnosis.result import EvidenceKind

POOLS = tuple(map(VehiclePool, range(40)))


@pytest.mark.parametrize("pool", POOLS[:4])
def test_every_lot_is_another_three_recordings(pool: VehiclePool) -> None:
    lots = [tuple(zip(lot[::2], lot[1::2], strict=True)) for lot in pool.lots]
    assert len({frozenset(lot) for lot in lots}) == len(lots)
    assert all(len(set(lot)) == EACH for lot in lots)


def test_the_two_truths_of_a_pool_never_look_alike() -> None:
    for pool in POOLS:
        (_, one, _), (_, two, _) = (pool.truths[letter] for letter in "AB")
        assert one != two
        assert two not in EQUIVALENT.get(one, set())


def test_no_two_recordings_share_their_noise() -> None:
    seeds = Counter(pool.trial(letter).seed for pool in POOLS for letter in "pcAB")
    assert max(seeds.values()) == 1


def row(pool: VehiclePool, lot: str, *names: str, reach: str = "transferred", how: str = "held-out") -> dict[str, Any]:
    named = [[*names, reach, how]] if names else []
    return {"key": f"{pool.seed}/{lot}", "truths": pool.truths, "names": named}


def hiding() -> tuple[VehiclePool, str]:
    """A pool whose first truth is an effect, and its name."""
    pool = next(one for one in POOLS if one.truths["A"][0] == "same")
    return pool, pool.truths["A"][1]


def test_what_one_recording_alone_hides_is_a_wrong_name() -> None:
    pool, name = hiding()
    assert wrong(row(pool, "A0p0p1", name)) == [name]
    assert wrong(row(pool, "A0A1p1", name)) == []


def test_a_truth_among_the_look_alikes_is_right() -> None:
    pool, name = hiding()
    assert wrong(row(pool, "A0A1A2", "quantisation", name)) == []


def test_of_a_class_that_differs_each_recording_may_hide_another() -> None:
    pool, name = hiding()
    other = pool.truths["B"][1]
    assert wrong(row(pool, "A0B1p1", name, other, reach="not-transferred")) == []
    assert wrong(row(pool, "A0B1p1", name, reach="not-transferred")) == [name]
    assert wrong(row(pool, "A0B1p1", name, other)) == [name]


def test_iron_differs_only_where_two_recordings_are_disturbed() -> None:
    pool, _ = hiding()
    assert wrong(row(pool, "A0B1p2", "scale", how=EvidenceKind.IRON)) == []
    assert wrong(row(pool, "A0p1p2", "scale", how=EvidenceKind.IRON)) == ["scale"]
    assert wrong(row(pool, "A0B1p2", "scale")) == ["scale"]


def test_an_attitude_that_walks_is_turned_as_a_field_with_an_error_is() -> None:
    def with_field(colour: str) -> VehiclePool:
        wanted = ("regional_field", colour)
        return next(one for one in map(VehiclePool, range(400)) if (one.truths["A"][1], one.truths["c"][1]) == wanted)

    pool, still = with_field("all"), with_field("flicker")
    assert wrong(row(pool, "A0c0p0", "regional_field", "attitude_misalignment")) == []
    assert wrong(row(pool, "A0p0p1", "regional_field", "attitude_misalignment")) == ["regional_field"]
    assert wrong(row(still, "A0c0p0", "regional_field", "attitude_misalignment")) == ["regional_field"]


def test_figures_count_lots_with_a_wrong_name() -> None:
    pool, name = hiding()
    found = figures([row(pool, "p0p1p2"), row(pool, "A0p0p1", name), row(pool, "A1p0p2")])
    assert (found["lots"], found["wrong"]) == (3, 1)
    assert found["by kind"] == {"ppp": [1, 0], "App": [2, 1]}
