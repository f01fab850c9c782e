"""The rerun recording of several recordings: the gap of each before and after, on one timeline."""

from __future__ import annotations

import zlib

import numpy as np
import rerun as rr
import rerun.blueprint as rrb

from diagnosis.several.result import PooledDiagnosis
from reports.palette import XYZ
from reports.plots.diagnosis import AFTER, BEFORE
from reports.series import block_means, length_for
from reports.viewer.stream import framed, name_part, recorded, scalars, static, time_view
from reports.words.together import headline

MOST_ROWS = 100_000


def together_recording(found: PooledDiagnosis, title: str) -> bytes:
    """The recording as the bytes of an .rrd file with its layout.

    On the timeline `time` (seconds since each recording's first sample): `<name>/residual/before` and `.../after`, the
    gap in nT with hard and soft iron fitted anew, after with the coefficients that the other recordings give.
    """

    def fill(stream: rr.RecordingStream) -> None:
        stream.send_recording_name(title)
        static(stream, "notes", rr.TextDocument(headline(found), media_type="text/markdown"))
        for name, own, *gaps in zip(found.names, found.each, found.before_nT, found.after_nT, strict=True):
            length = length_for(len(own.problem.recording), MOST_ROWS)
            time_s = block_means(own.problem.state.time_s, length)
            for part, gap, colour in zip(("before", "after"), gaps, (BEFORE, AFTER), strict=True):
                labels, colours = (["x", "y", "z"], XYZ) if gap.shape[1] == 3 else ([part], (colour,))
                thin = block_means(gap, length, own.problem.usable)
                scalars(stream, f"{name_part(name)}/residual/{part}", time_s, thin, labels, colours)

    name = f"together_{zlib.crc32(b''.join(gap.tobytes() for gap in found.before_nT)):08x}"
    return recorded(name, _layout(found), fill)


def _layout(found: PooledDiagnosis) -> rrb.Blueprint:
    tabs = []
    for name, own, before in zip(found.names, found.each, found.before_nT, strict=True):
        time_s = own.problem.state.time_s
        low = -1.5 * float(np.nanmax(np.abs(block_means(before, length_for(len(before), 4000))))) or None
        views = [
            time_view(f"{text} (nT)", time_s, f"{name_part(name)}/residual/{part}", low=low)
            for part, text in (("before", "the model as given"), ("after", found.among.after))
        ]
        tabs.append(rrb.Grid(*views, grid_columns=1, name=name))
    notes = rrb.TextDocumentView(origin="notes", name="Together")
    return framed(rrb.Horizontal(rrb.Tabs(*tabs, active_tab=0), notes, column_shares=[3, 2]))
