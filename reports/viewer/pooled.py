"""The rerun recording of several recordings: the gap of each before and after, on one timeline."""

from __future__ import annotations

import zlib

import numpy as np
import rerun as rr
import rerun.blueprint as rrb

from diagnosis.several.result import PooledDiagnosis
from reports.gap_series import block_length, block_means
from reports.palette import XYZ
from reports.plots.diagnosis import AFTER, BEFORE
from reports.text.pooled import headline
from reports.viewer.stream import entity_name, layout, recording_bytes, send_scalars, send_static, time_view

MOST_ROWS = 100_000


def pooled_recording(found: PooledDiagnosis, title: str) -> bytes:
    """The recording as the bytes of an .rrd file with its layout.

    On the timeline `time` (seconds since each recording's first sample): `<name>/residual/before` and `.../after`, the
    gap in nT with hard and soft iron fitted anew, after with the coefficients that the other recordings give.
    """

    def fill(stream: rr.RecordingStream) -> None:
        stream.send_recording_name(title)
        send_static(stream, "notes", rr.TextDocument(headline(found), media_type="text/markdown"))
        for name, own, *gaps in zip(found.names, found.each, found.before_nT, found.after_nT, strict=True):
            length = block_length(len(own.problem.recording), MOST_ROWS)
            time_s = block_means(own.problem.state.time_s, length)
            for part, gap, colour in zip(("before", "after"), gaps, (BEFORE, AFTER), strict=True):
                labels, colours = (["x", "y", "z"], XYZ) if gap.shape[1] == 3 else ([part], (colour,))
                thin = block_means(gap, length, own.problem.usable)
                send_scalars(stream, f"{entity_name(name)}/residual/{part}", time_s, thin, labels, colours)

    name = f"together_{zlib.crc32(b''.join(gap.tobytes() for gap in found.before_nT)):08x}"
    return recording_bytes(name, _layout(found), fill)


def _layout(found: PooledDiagnosis) -> rrb.Blueprint:
    tabs = []
    for name, own, before in zip(found.names, found.each, found.before_nT, strict=True):
        time_s = own.problem.state.time_s
        low = -1.5 * float(np.nanmax(np.abs(block_means(before, block_length(len(before), 4000))))) or None
        views = [
            time_view(f"{text} (nT)", time_s, f"{entity_name(name)}/residual/{part}", low=low)
            for part, text in (("before", "the model as given"), ("after", found.among.after))
        ]
        tabs.append(rrb.Grid(*views, grid_columns=1, name=name))
    notes = rrb.TextDocumentView(origin="notes", name="Together")
    return layout(rrb.Horizontal(rrb.Tabs(*tabs, active_tab=0), notes, column_shares=[3, 2]))
