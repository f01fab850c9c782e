"""A calibration in place of a model: the iron that a diagnosis fits, compared with the iron that is stated."""

from __future__ import annotations

from collections.abc import Sequence
from os import PathLike
from pathlib import Path
from typing import TYPE_CHECKING

from scenarios.errors import InputError

if TYPE_CHECKING:
    from calib.reference import Reference
    from diagnosis.question import Source
    from recordings import Recording
    from reports.presentation.stated_iron import StatedIron

MODELS = (".toml",)
"""Endings of scenario and model files."""


def is_calibration(model: str | PathLike[str] | None) -> bool:
    """Whether a model is a file of another kind than scenarios: a calibration, which names the iron alone."""
    return model is not None and Path(model).is_file() and Path(model).suffix not in MODELS


def stated_iron(
    model: str | PathLike[str] | None,
    sources: Sequence[Source],
    strength_nT: float | None,
    vector_nT: Sequence[float] | None,
) -> tuple[StatedIron, ...]:
    """The answer on a calibration in place of the model by each recording; none for a model.

    strength_nT, vector_nT : of the field; None: each recording's own.
    """
    from reports.presentation.stated_iron import StatedIron

    if model is None or not is_calibration(model):
        return ()
    from magbench.api.recheck import judged

    found = []
    for source in sources:
        whole = source.read()
        recording = whole if whole.array_mag_nT is None else whole.sensor((source.sensor or 1) - 1)
        field = _field(source, recording, strength_nT, vector_nT)
        sensor = None if whole.array_mag_nT is None else source.sensor or 1
        found.append(StatedIron(source.name, judged(model, recording, field, sensor=sensor)))
    return tuple(found)


def _field(
    source: Source, recording: Recording, strength_nT: float | None, vector_nT: Sequence[float] | None
) -> Reference | None:
    """The stated field, else the recording's own; None where nothing tells the field, and for counts."""
    from validation.calibrating.reference import told_field

    if recording.origin.unit != "nT":
        return None
    try:
        return source.reference(*told_field(strength_nT, vector_nT, recording.origin, recording.mag_nT), "")
    except InputError:
        if strength_nT is not None or vector_nT is not None:
            raise
        return None
