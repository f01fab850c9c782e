"""What the speed of `simulate` is measured on."""

from __future__ import annotations

import numpy as np
import pytest

from benchmarks.dataset import every_effect
from recordings import read_run
from sim.dataset_writer import generate
from sim.effects.earth import AttitudeMisalignment


@pytest.mark.slow
def test_every_effect_of_the_benchmark_acts(tmp_path):
    generate(every_effect(0.02), tmp_path / "out")
    _, truth = read_run(tmp_path / "out")
    quiet = {name for name, label_nT in truth.effects.items() if not np.abs(label_nT).max() > 0}
    assert quiet <= {AttitudeMisalignment.name}  # it turns what navigation says, not the field
    assert len(truth.effects) > 20
