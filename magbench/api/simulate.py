"""`magbench.simulate`."""

from __future__ import annotations

from collections.abc import Sequence
from os import PathLike
from pathlib import Path
from typing import TYPE_CHECKING, overload

from magbench.api.dataset import dataset
from magbench.api.inputs import Progress, Warn, check_count, in_keywords, quiet, scenario_from, tasks_on

if TYPE_CHECKING:
    from recordings import Recording, Truth
    from recordings.loading import RunSet
    from sim.scenario import Scenario


@overload
def simulate(
    scenario: str | Path | Scenario, out: None = None, *, overrides: Sequence[str] = (), seed: int | None = None
) -> tuple[Recording, Truth]: ...
@overload
def simulate(
    scenario: str | Path | Scenario,
    out: str | PathLike[str],
    *,
    overrides: Sequence[str] = (),
    seed: int | None = None,
    runs: int = 1,
    runs_per_file: int = 1,
    split: str | None = None,
    jobs: int = 1,
    scheduler: str | None = None,
    progress: Progress = quiet,
    warn: Warn = quiet,
) -> RunSet: ...
@in_keywords()
def simulate(
    scenario: str | Path | Scenario,
    out: str | PathLike[str] | None = None,
    *,
    overrides: Sequence[str] = (),
    seed: int | None = None,
    runs: int = 1,
    runs_per_file: int = 1,
    split: str | None = None,
    jobs: int = 1,
    scheduler: str | None = None,
    progress: Progress = quiet,
    warn: Warn = quiet,
) -> tuple[Recording, Truth] | RunSet:
    """One run of a scenario, by name, file or `magbench.load`: the recording and its truth; with `out` a dataset.

    overrides : `effects.white_noise.std_nT=[5,5,5]` and the like.
    out : directory of the dataset, which is returned as by `magbench.dataset`; the same call resumes or adds runs.
    runs_per_file : runs that share a file. split : `80/10/10`, parts for training, validation and test. jobs :
        processes. scheduler : address of a Dask cluster, `tcp://host:8786`, whose workers write to `out`. Neither jobs
        nor scheduler changes a byte.

    Raises InputError for a bad scenario, and for an `out` with another dataset.

    >>> import magbench
    >>> recording, truth = magbench.simulate("tumble", overrides=["phases.0.duration_s=60"])
    >>> recording.mag_nT.shape == truth.field_nT.shape == (600, 3)
    True
    >>> len(magbench.simulate("tumble", "data", runs=2, overrides=["phases.0.duration_s=60"]))
    2
    """
    spec = scenario_from(scenario, overrides)
    if out is None:
        _check_single(runs, runs_per_file, split, scheduler)
        return _in_memory(spec, seed)
    from recordings.url_path import place_at
    from sim.dataset_writer import generate

    check_count("--runs", runs)
    check_count("--jobs", jobs)
    generate(
        spec,
        place_at(str(out)),
        runs=runs,
        seed=seed,
        jobs=jobs,
        split=split,
        runs_per_file=runs_per_file,
        engine=tasks_on(scheduler),
        progress=progress,
        warn=warn,
    )
    return dataset(out)


def _check_single(runs: int, runs_per_file: int, split: str | None, scheduler: str | None) -> None:
    """Raise InputError for several runs, or a cluster, without a directory."""
    from scenarios.errors import InputError

    if (runs, runs_per_file, split, scheduler) != (1, 1, None, None):
        raise InputError("a dataset needs a directory", where="--out", do="name one, or leave out runs and scheduler")


def _in_memory(scenario: Scenario, seed: int | None) -> tuple[Recording, Truth]:
    from tempfile import TemporaryDirectory

    from recordings import read_run
    from sim.dataset_writer import generate

    with TemporaryDirectory(prefix="magbench-") as place:
        generate(scenario, Path(place), seed=seed)
        return read_run(Path(place))
