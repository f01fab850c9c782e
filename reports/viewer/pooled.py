"""Rerun recording of a pooled diagnosis: gap of each recording before and after, on a common timeline."""

from __future__ import annotations

import zlib

import rerun as rr
import rerun.blueprint as rrb

from diagnosis.several.result import PooledDiagnosis
from reports.gap_series import block_length, block_means, value_axis_low
from reports.palette import AFTER, BEFORE, XYZ
from reports.text.diagnosis import headline
from reports.viewer.stream import entity_name, layout, recording_bytes, send_scalars, send_static, time_view

MOST_ROWS = 100_000


def pooled_recording(pooled: PooledDiagnosis, title: str) -> bytes:
    """Return the recording with its layout as the bytes of an .rrd file.

    Timeline `time`: seconds since each recording's first sample. `<name>/residual/before` and `<name>/residual/after`:
    gap in nT with hard and soft iron refitted, after with the coefficients of the remaining recordings.
    """

    def fill(stream: rr.RecordingStream) -> None:
        stream.send_recording_name(title)
        send_static(stream, "notes", rr.TextDocument(headline(pooled), media_type="text/markdown"))
        for name, own, *gaps in zip(pooled.names, pooled.each, pooled.before_nT, pooled.after_nT, strict=True):
            length = block_length(len(own.problem.recording), MOST_ROWS)
            time_s = block_means(own.problem.state.time_s, length)
            for part, gap, colour in zip(("before", "after"), gaps, (BEFORE, AFTER), strict=True):
                labels, colours = (["x", "y", "z"], XYZ) if gap.shape[1] == 3 else ([part], (colour,))
                thin = block_means(gap, length, own.problem.usable)
                send_scalars(stream, f"{entity_name(name)}/residual/{part}", time_s, thin, labels, colours)

    name = f"together_{zlib.crc32(b''.join(gap.tobytes() for gap in pooled.before_nT)):08x}"
    return recording_bytes(name, _layout(pooled), fill)


def _layout(pooled: PooledDiagnosis) -> rrb.Blueprint:
    tabs = []
    for name, own, before in zip(pooled.names, pooled.each, pooled.before_nT, strict=True):
        time_s = own.problem.state.time_s
        low = value_axis_low(before)
        views = [
            time_view(f"{text} (nT)", time_s, f"{entity_name(name)}/residual/{part}", low=low)
            for part, text in (("before", "the model as given"), ("after", pooled.scope.after))
        ]
        tabs.append(rrb.Grid(*views, grid_columns=1, name=name))
    notes = rrb.TextDocumentView(origin="notes", name="Together")
    return layout(rrb.Horizontal(rrb.Tabs(*tabs, active_tab=0), notes, column_shares=[3, 2]))
