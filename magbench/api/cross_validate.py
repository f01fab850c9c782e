"""`magbench.worth`: cross-validation of models of growing size."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

from magbench.api.inputs import Data, in_keywords, reading_from, recording_and_reference

if TYPE_CHECKING:
    from magbench.api.worth_result import WorthResult
    from recordings.reading import Reading


@in_keywords()
def worth(
    data: Data,
    field_strength_nT: float | None = None,
    *,
    field_enu_nT: Sequence[float] | None = None,
    maps: Sequence[str] = (),
    reading: Reading | None = None,
    run: int = 0,
) -> WorthResult:
    """Whether soft iron, eddy currents and a temperature predict unseen legs better; of each sensor.

    Data and reference as in `calibrate`.

    >>> import magbench
    >>> import numpy as np
    >>> recording, truth = magbench.simulate("tumble", overrides=["phases.0.duration_s=60"])
    >>> strength_nT = float(np.linalg.norm(truth.field_nT[0]))
    >>> (found,) = magbench.worth(recording, strength_nT)
    >>> found.keep
    'ellipsoid'
    """
    from magbench.api.worth_result import WorthResult
    from validation.cross_validation.workflow import cross_validate

    read = reading_from(data, maps, reading)
    field = field_strength_nT, field_enu_nT
    return WorthResult(cross_validate(*recording_and_reference(data, field, reading=read, run=run)))
