"""A Dask cluster gives the same bytes; one that is not there, or goes away, is one line."""

from __future__ import annotations

import logging
import pickle
import sys
import threading
from collections.abc import Iterator
from contextlib import closing
from pathlib import Path

import pytest

from reports.outputs.comparison import compare
from scenarios.errors import InputError
from validation.comparison.cluster import Cluster
from validation.comparison.design import Design
from validation.comparison.engine import GoneError, SerialEngine, run_trials
from validation.comparison.journal import Journal
from validation.comparison.trial import PendingTrial, Trial
from validation.comparison.trial_table import TRIALS

distributed = pytest.importorskip("distributed", reason="the extra `cluster` is not installed")


@pytest.fixture
def cluster() -> Iterator[object]:
    """A scheduler and a worker in this process."""
    silent = {"dashboard_address": None, "silence_logs": False}
    with distributed.LocalCluster(n_workers=1, threads_per_worker=1, processes=False, protocol="tcp", **silent) as made:
        yield made


def test_the_same_bytes_as_here(design: Design, cluster, tmp_path: Path) -> None:  # type: ignore[no-untyped-def]
    files = []
    for name, engine in (("here", SerialEngine()), ("cluster", Cluster(cluster.scheduler_address, patience_s=20.0))):
        compare(design, 3, tmp_path / name, engine)
        files.append((tmp_path / name / TRIALS).read_bytes())
    assert files[0] == files[1]


def test_a_scheduler_that_goes_away_leaves_what_has_landed(design: Design, cluster, tmp_path: Path) -> None:  # type: ignore[no-untyped-def]
    engine = Cluster(cluster.scheduler_address, patience_s=1.0)
    journal = Journal.open(tmp_path, design.identity())
    trials = run_trials(design, range(100), engine, journal)
    next(trials)
    cluster.close()
    with pytest.raises(InputError, match=r"has not answered for 1 s; [1-9]\d* trials? kept .*it resumes"):
        list(trials)
    assert len(list(journal)) >= 1


@pytest.mark.parametrize("stopped", [False, True], ids=["the answer is lost", "the scheduler has stopped"])
def test_a_scheduler_that_goes_away_while_a_result_is_fetched_is_waited_for(
    stopped: bool,
    design: Design,
    cluster,  # type: ignore[no-untyped-def]
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """A lost answer is computed again by a new connection; a scheduler that stays away is one line."""
    fetch, lost = distributed.Future.result, list[object]()

    def fetched(future: object, **options: object) -> object:
        if not lost:
            lost.append(future)
            if stopped:
                cluster.close()
            else:
                raise distributed.comm.CommClosedError("in <TCP local=tcp://127.0.0.1:1>: Stream is closed")
        return fetch(future, **options)

    monkeypatch.setattr(distributed.Future, "result", fetched)
    journal = Journal.open(tmp_path, design.identity())
    trials = run_trials(design, range(2), Cluster(cluster.scheduler_address, patience_s=5.0), journal)
    if stopped:
        with pytest.raises(InputError, match="has not answered for 5 s; no trial kept"):
            list(trials)
    else:
        assert sorted((trial.point, trial.run) for trial in trials) == [(0, 0), (0, 1), (1, 0), (1, 1)]


def test_an_error_of_a_trial_is_not_taken_for_a_lost_scheduler(cluster) -> None:  # type: ignore[no-untyped-def]
    task = PendingTrial(b"not a design", 0, 0)
    with pytest.raises(pickle.UnpicklingError):
        list(Cluster(cluster.scheduler_address, patience_s=5.0).trials([task], failing))


def failing(task: PendingTrial) -> Trial:
    raise AssertionError(task)


def test_no_scheduler_no_address_no_package(design: Design, monkeypatch: pytest.MonkeyPatch) -> None:
    with pytest.raises(InputError, match="has not answered"):
        list(run_trials(design, [0], Cluster("tcp://127.0.0.1:9", patience_s=0.1)))
    with pytest.raises(InputError, match="tcp://host:8786"):
        list(run_trials(design, [0], Cluster("nonsense://x", patience_s=0.1)))
    monkeypatch.setitem(sys.modules, "distributed", None)
    with pytest.raises(InputError, match=r"magbench\[cluster\]"):
        list(run_trials(design, [0], Cluster("tcp://127.0.0.1:9")))


def doubled(number: int) -> int:
    return 2 * number


@pytest.mark.parametrize("threads", [1, 2])
def test_two_tasks_a_thread_are_taken_ahead_and_no_more(threads: int) -> None:
    """Tasks are made as they are taken, so that a million take no memory."""
    taken = list[int]()

    def items() -> Iterator[int]:
        for number in range(12):
            taken.append(number)
            yield number

    silent = {"dashboard_address": None, "silence_logs": False, "processes": False, "protocol": "tcp"}
    with distributed.LocalCluster(n_workers=1, threads_per_worker=threads, **silent) as made:
        found, ahead = dict[int, int](), list[int]()
        with closing(Cluster(made.scheduler_address, patience_s=20.0).map(doubled, items())) as results:
            for number, result in results:
                ahead.append(len(taken) - len(found))
                found[number] = result
    assert found == {number: 2 * number for number in range(12)}
    assert ahead[:6] == [2 * threads] * 6


def test_a_scheduler_without_a_worker_is_waited_for_and_then_given_up() -> None:
    """A worker that comes in time does the work; what is said otherwise is how long was waited, by default a minute."""
    silent = {"dashboard_address": None, "silence_logs": False, "processes": False, "protocol": "tcp"}
    with distributed.LocalCluster(n_workers=0, **silent) as made:
        with pytest.raises(GoneError, match=r"has had no worker for 0\.5 s"):
            list(Cluster(made.scheduler_address, patience_s=0.5).map(doubled, [1]))
        late = threading.Timer(1.5, made.scale, [1])
        late.start()
        assert list(Cluster(made.scheduler_address, patience_s=20.0).map(doubled, [1, 2])) == [(1, 2), (2, 4)]
        late.join()
    assert "has had no worker for 60 s" in str(Cluster("tcp://here:8786").missing("has had no worker"))


def test_what_dask_logs_of_lost_connections_is_not_shown_meanwhile(cluster) -> None:  # type: ignore[no-untyped-def]
    """However grave; before and after it is."""
    shown = list[str]()
    handler = logging.Handler()
    handler.emit = lambda record: shown.append(record.getMessage())  # type: ignore[method-assign]
    loggers = [logging.getLogger(name) for name in ("distributed", "tornado", "asyncio")]
    for logger in loggers:
        logger.addHandler(handler)
    try:
        with closing(Cluster(cluster.scheduler_address, patience_s=20.0).map(doubled, [1])) as results:
            for _ in results:
                for logger in loggers:
                    logger.critical("meanwhile")
        for logger in loggers:
            logger.critical("afterwards")
    finally:
        for logger in loggers:
            logger.removeHandler(handler)
    assert [text for text in shown if text in ("meanwhile", "afterwards")] == ["afterwards"] * 3
