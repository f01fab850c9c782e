"""A run in memory, without files: recording and truth."""

from __future__ import annotations

from collections.abc import Iterable
from pathlib import Path

import numpy as np

from recordings.assemble import recording_of, truth_of
from recordings.checks import check_columns, check_truth
from recordings.files import canonical_json
from recordings.importer import RawColumns
from recordings.metadata import TrueParameters
from recordings.recording import Recording, Truth
from sim.motion import Motion
from sim.simulation import PreparedRun, blocks

CALLED = Path("simulated run")
"""Name of the run in messages, in place of a file name."""


def run_in_memory(plan: PreparedRun, motions: Iterable[Motion] | None = None) -> tuple[Recording, Truth]:
    """The run as `recordings.read_run` reads it from the file of `sim.dataset_writer`, equal to the bit.

    motions : the run's true motion if already computed. Raises InputError where the vehicle cannot do the motion.
    """
    pieces = list(blocks(plan, motions))
    raw = RawColumns(CALLED, {name: np.concatenate([piece[name] for piece in pieces]) for name in pieces[0]})
    parameters = TrueParameters.model_validate_json(canonical_json(plan.metadata["parameters"]))
    return recording_of(check_columns(raw)), truth_of(check_truth(raw), parameters.model_dump(exclude_unset=True))
