"""Two thousand disturbed logs and as many sound ones as each kind has: the shares that the bars are for."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator
from multiprocessing import get_context
from pathlib import Path
from tempfile import TemporaryDirectory

from benchmarks.honesty.logs import DISTURBANCES, log_of
from benchmarks.honesty.verdicts import Verdict, verdict
from benchmarks.measure import Row

LOGS = 2000
"""Disturbed logs of the whole bench."""
SMALL = 1
"""Logs of each kind with which a test runs the bench."""
WRONG, NAMED, REFUSED = 0.05, 0.9, 0.01
"""Bars: `ok` beyond the claim, reasons that name the disturbance, sound logs refused."""
KINDS = tuple(name for name in DISTURBANCES if name != "sound")


def each_of(logs: int) -> int:
    """Return the logs of each kind for a number of disturbed logs."""
    return -(-logs // len(KINDS))


def verdicts(each: int, jobs: int = 1, kinds: Iterable[str] = DISTURBANCES) -> list[Verdict]:
    """Return the verdicts on `each` logs of every kind; as many processes as jobs."""
    tasks = [(kind, seed) for seed in range(each) for kind in kinds]
    if jobs == 1:
        return [_judged(task) for task in tasks]
    with get_context("spawn").Pool(jobs) as pool:
        return pool.map(_judged, tasks, chunksize=4)


def _judged(task: tuple[str, int]) -> Verdict:
    kind, seed = task
    with TemporaryDirectory(prefix="magbench-") as place:
        return verdict(log_of(kind, 1000 * list(DISTURBANCES).index(kind) + seed), Path(place))


def table(found: list[Verdict]) -> Iterator[str]:
    """Yield a line for each kind: logs, statuses, ok beyond the claim, reasons that name, agreement."""
    yield f"{'':16} {'logs':>5} {'ok':>5} {'wrong':>6} {'named':>6} {'agree':>6}"
    for kind in DISTURBANCES:
        own = [one for one in found if one.disturbance == kind]
        if own:
            counts = [sum(map(of, own)) for of in (_is_ok, _is_wrong, _is_named, _agrees)]
            yield f"{kind:16} {len(own):5} {counts[0]:5} {counts[1]:6} {counts[2]:6} {counts[3]:6}"


def _is_ok(one: Verdict) -> bool:
    return one.ok


def _is_wrong(one: Verdict) -> bool:
    return one.wrong


def _is_named(one: Verdict) -> bool:
    return one.explained


def _agrees(one: Verdict) -> bool:
    return one.agree


def rows_of(found: list[Verdict]) -> Iterator[Row]:
    """Yield the four shares against their bars."""
    disturbed = [one for one in found if one.disturbance != "sound"]
    sound = [one for one in found if one.disturbance == "sound"]
    of = f"of {len(disturbed)} disturbed logs"
    yield Row("ok with an error beyond the claimed 95 %", _share(disturbed, _is_wrong), WRONG, False, of)
    yield Row("reasons that name the disturbance", _share(disturbed, _is_named), NAMED, True, of)
    yield Row("sound logs refused", 1 - _share(sound, _is_ok), REFUSED, False, f"of {len(sound)} sound logs")
    yield Row("inspect and calibrate agree", _share(found, _agrees), 1.0, True, f"of {len(found)} logs")


def _share(found: list[Verdict], of: Callable[[Verdict], bool]) -> float:
    return sum(map(of, found)) / len(found)


def rows(small: bool = False) -> Iterator[Row]:
    """Yield the shares of the whole bench, or of a log of each kind."""
    yield from rows_of(verdicts(SMALL if small else each_of(LOGS)))
