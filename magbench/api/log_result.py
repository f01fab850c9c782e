"""A vehicle's log as a result: recording, summary, table and picture."""

from __future__ import annotations

from dataclasses import asdict, dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

from magbench.api.displayed import Displayed

if TYPE_CHECKING:
    import pandas as pd

    from recordings import Recording
    from reports.plots.style import Figure


@dataclass(frozen=True, eq=False, repr=False)
class LogResult(Displayed):
    """A vehicle's log as a recording, and what the log tells of itself.

    form : the file's format. field_enu_nT : the world model's field at the place and date in the log, else None.
    """

    path: Path
    form: str
    recording: Recording
    field_enu_nT: tuple[float, float, float] | None

    def __repr__(self) -> str:
        """Format, samples and length."""
        return f"{self.path.name}: {self.form}. {self.recording!r}"

    @property
    def rate_hz(self) -> float:
        """The rate of the magnetometer's samples, from the median interval."""
        from recordings.streams import own_interval_s

        return 1 / own_interval_s(self.recording.time_s)

    def summary(self) -> dict[str, Any]:
        """What was found and what was done, as plain values: the JSON of `magbench read`."""
        from recordings.log_facts import LogFacts

        origin, time_s = self.recording.origin, self.recording.time_s
        known = {"samples": len(time_s), "length_s": float(time_s[-1] - time_s[0]), "rate_hz": self.rate_hz}
        facts = LogFacts.of(origin).model_dump(mode="json") | {"magnetometers": list(origin.magnetometers)}
        told = {"field_enu_nT": None if self.field_enu_nT is None else list(self.field_enu_nT)}
        columns = [asdict(column) for column in self._columns()]
        return {"log": str(self.path), "format": self.form, **known, **facts, **told, "columns": columns} | {
            "notes": list(origin.notes)
        }

    def _columns(self) -> tuple[Any, ...]:
        from recordings.columns import columns_of

        return columns_of(self.recording)

    def to_frame(self) -> pd.DataFrame:
        """A row a numeric column: unit, lowest, median and highest value, and the meaning."""
        import numpy as np
        import pandas as pd

        from recordings.assemble import arrays_of

        arrays = arrays_of(self.recording)
        rows = [
            (one.name, one.unit, *np.quantile(arrays[one.name], (0.0, 0.5, 1.0)), one.meaning)
            for one in self._columns()
            if one.name in arrays and arrays[one.name].dtype.kind == "f"
        ]
        return pd.DataFrame(rows, columns=["column", "unit", "lowest", "median", "highest", "meaning"])

    def plot(self) -> Figure:
        """Components and strength of the measured field over time."""
        from reports.plots.recording import draw_recording

        return draw_recording(self.recording)
