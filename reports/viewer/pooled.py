"""Rerun recording of a pooled diagnosis: gap of each recording before and after, on a common timeline."""

from __future__ import annotations

import zlib
from collections.abc import Iterator

import rerun.blueprint as rrb

from reports.palette import AFTER, BEFORE, XYZ
from reports.presentation.pooled import PresentedPool
from reports.viewer.stream import Content, entity_name, gap_views, layout, recording_bytes, scalars, text

MOST_ROWS = 100_000


def pooled_recording(pooled: PresentedPool, title: str) -> bytes:
    """Return the recording with its layout as the bytes of an .rrd file.

    Timeline `time`: seconds since each recording's first sample. `<name>/residual/before` and `<name>/residual/after`:
    gap in nT with hard and soft iron refitted, after with the coefficients of the remaining recordings.
    """
    name = f"together_{zlib.crc32(b''.join(gap.before_nT.tobytes() for gap in pooled.series)):08x}"
    return recording_bytes(name, title, _layout(pooled), _contents(pooled))


def _contents(pooled: PresentedPool) -> Iterator[Content]:
    yield text(pooled.headline)
    for name, gap in zip(pooled.names, pooled.series, strict=True):
        thin = gap.thinned(MOST_ROWS)
        for (side, gap_nT), colour in zip(thin.sides.items(), (BEFORE, AFTER), strict=True):
            labels, colours = ("xyz", XYZ) if gap_nT.shape[1] == 3 else ([side], (colour,))
            yield scalars(f"{entity_name(name)}/residual/{side}", thin.time_s, gap_nT, labels, colours)


def _layout(pooled: PresentedPool) -> rrb.Blueprint:
    gaps = zip(pooled.names, pooled.series, strict=True)
    tabs = [gap_views(gap, f"{entity_name(name)}/residual", pooled.scope.after, name) for name, gap in gaps]
    notes = rrb.TextDocumentView(origin="notes", name="Together")
    return layout(rrb.Horizontal(rrb.Tabs(*tabs, active_tab=0), notes, column_shares=[3, 2]))
