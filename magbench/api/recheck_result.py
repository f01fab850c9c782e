"""The answer on an old calibration as a result: sentence, table and picture."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from magbench.api.displayed import Displayed, values_of
from validation.rechecking.recheck import Recheck

if TYPE_CHECKING:
    import pandas as pd

    from calib.result import Calibration
    from recordings import Recording
    from reports.plots.style import Figure


@dataclass(frozen=True, eq=False, kw_only=True, repr=False)
class RecheckResult(Recheck, Displayed):
    """Whether an old calibration is valid, with the calibration and the new log."""

    old: Calibration
    recording: Recording

    @classmethod
    def of(cls, found: Recheck, old: Calibration, recording: Recording) -> RecheckResult:
        """An answer with its input."""
        return cls(**values_of(found), old=old, recording=recording)

    def __repr__(self) -> str:
        """The verdict in a sentence."""
        from validation.rechecking.summary import headline

        return headline(self)

    def summary(self) -> dict[str, Any]:
        """The verdict and every figure as plain values: the JSON of `magbench recheck`."""
        from validation.rechecking.summary import summary

        return {"old": self.old.name} | summary(self)

    def to_frame(self) -> pd.DataFrame:
        """A row a part: change, interval, heading error, chance."""
        import pandas as pd

        from validation.rechecking.summary import HEADS, rows

        return pd.DataFrame(rows(self), columns=HEADS)

    def plot(self) -> Figure:
        """The new log's field, raw and as the old calibration corrects it."""
        import numpy as np

        from reports.plots.field import draw_clouds
        from validation.rechecking.logged_inputs import with_logged_inputs

        corrected_nT = with_logged_inputs(self.old, self.recording)[0].apply(self.recording)
        clouds = {"raw": self.recording.mag_nT, f"corrected: {self.old.name}": corrected_nT}
        return draw_clouds(clouds, float(np.median(np.linalg.norm(corrected_nT, axis=1))))
