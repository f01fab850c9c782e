"""A Dask cluster gives the same bytes; one that is not there, or goes away, is one line."""

from __future__ import annotations

import pickle
import sys
from collections.abc import Iterator
from pathlib import Path

import pytest

from reports.outputs.comparison import compare
from scenarios.errors import InputError
from validation.comparison.cluster import Cluster
from validation.comparison.design import Design
from validation.comparison.engine import SerialEngine, run_trials
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
