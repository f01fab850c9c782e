"""`magbench.simulate`."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

from magbench.api.inputs import in_keywords, scenario_from

if TYPE_CHECKING:
    from recordings import Recording, Truth
    from sim.scenario import Scenario


@in_keywords()
def simulate(
    scenario: str | Path | Scenario, *, overrides: Sequence[str] = (), seed: int | None = None
) -> tuple[Recording, Truth]:
    """One run of a scenario, by name, file or `magbench.load`: the recording and its truth.

    overrides : `effects.white_noise.std_nT=[5,5,5]` and the like. `magbench.generate` writes many runs to files.
    """
    from tempfile import TemporaryDirectory

    from recordings import read_run
    from sim.dataset_writer import generate

    with TemporaryDirectory(prefix="magbench-") as place:
        generate(scenario_from(scenario, overrides), Path(place), seed=seed)
        return read_run(Path(place))
