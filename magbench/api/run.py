"""`magbench.run`."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from os import PathLike
from pathlib import Path
from typing import TYPE_CHECKING

from magbench.api.inputs import Progress, calibrators_from, in_keywords, place_for, scenario_from

if TYPE_CHECKING:
    from magbench.api.run_result import RunResult
    from sim.scenario import Scenario


@in_keywords()
def run(
    scenario: str | Path | Scenario,
    out: str | PathLike[str] | None = None,
    *,
    with_: Sequence[str] = (),
    overrides: Sequence[str] = (),
    seed: int | None = None,
    exec_: Sequence[str] = (),
    time_limit_s: float | None = None,
    full: bool = False,
    progress: Progress = lambda done, total: None,
    warn: Callable[[str], object] = lambda text: None,
) -> RunResult:
    """Simulate a scenario, calibrate, and score against the truth; with `out` write report and recording there.

    with_, exec_ : the calibrators, as in `calibrate`; by default the scenario's. full : recording.rrd keeps every
    sample. progress : called with (stages done, stages in all); warn : with a line about an incident.

    Raises InputError for a bad scenario, an unknown calibrator, and an `out` that holds another dataset.

    >>> import magbench
    >>> found = magbench.run("tumble", with_=["sphere", "ellipsoid"], overrides=["phases.0.duration_s=60"])
    >>> names, score = found.ranking()
    >>> names[0], score
    ('ellipsoid', 'holdout_level_component_rms')
    """
    from magbench.api.run_result import RunResult
    from reports.outputs.run import run_scenario, simulate_and_score

    spec = scenario_from(scenario, overrides)
    asked = (str(scenario) if isinstance(scenario, str | Path) else "", *overrides)
    chosen = calibrators_from(with_, exec_, time_limit_s, spec.calibrators)
    if out is not None:
        return RunResult.of(
            run_scenario(
                spec, Path(out), seed=seed, chosen=chosen, full=full, asked=asked, progress=progress, warn=warn
            )
        )
    with place_for(None) as place:
        return RunResult.of(simulate_and_score(spec, place, seed, chosen, progress, warn))
