"""Parts of every recording: bytes made in memory, series, names of entities, views."""

from __future__ import annotations

import time
from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import rerun as rr
import rerun.blueprint as rrb

from recordings.files import atomic_write, system_errors_about
from reports.palette import LINES, XYZ, rgb
from reports.presentation.series import MOST_BLOCKS, GapSeries, block_length, block_means
from scenarios.arrays import Array
from scenarios.errors import InputError

TIMELINE = "time"
ROWS_A_CHUNK = 65_536
MOST_POSES = 20_000
TRUE, MEASURED, DIFFERENCE = LINES[5], LINES[1], LINES[3]
"""Colours that show on the viewer's dark and on its light ground."""


class Rows(NamedTuple):
    """Rows of an entity at times (n,) in s, made by ``kind.columns``; values: arrays (n, ...) by its keywords."""

    time_s: Array
    kind: Any
    values: Mapping[str, Array]


class Content(NamedTuple):
    """Content of an entity: an archetype that holds at all times, and rows over time."""

    entity: str
    static: Any = None
    rows: Rows | None = None


def recording_bytes(
    name: str, title: str, blueprint: rrb.Blueprint, contents: Iterable[Content], **about: Any
) -> bytes:
    """Return the bytes of a recording with a layout; about: properties.

    Raises InputError where rerun is off, and for a clock before 1970, at which rerun would end the process.
    """
    if time.time() < 0.0:
        raise InputError("is before 1970: no recording for the viewer", where="the system's clock", do="set the clock")
    stream = rr.RecordingStream(f"magbench_{name}")
    # rerun's own file writer does not say that a disk is full: it waits for ever, or leaves the file without its end.
    memory = stream.memory_recording()
    if stream.get_application_id() is None:
        raise InputError("turns recordings off", where="environment variable RERUN", do="unset it")
    try:
        # active, since a viewer that reads by HTTP makes a layout of its own before the default one has arrived
        stream.send_blueprint(blueprint, make_active=True, make_default=True)
        stream.send_recording_name(title)
        for key, value in about.items():
            stream.send_property(key, value)
        for content in contents:
            _send(stream, content)
        return bytes(memory.drain_as_bytes())
    finally:
        stream.disconnect()


def _send(stream: rr.RecordingStream, content: Content) -> None:
    """Send static content, then the rows in chunks; times to the nanosecond."""
    if content.static is not None:
        stream.log(content.entity, content.static, static=True, strict=True)
    if content.rows is None:
        return
    time_s, kind, values = content.rows
    whole_ns = np.round(1e9 * time_s).astype("timedelta64[ns]")  # given seconds, rerun would cut, not round
    for first in range(0, len(whole_ns), ROWS_A_CHUNK):
        part = slice(first, first + ROWS_A_CHUNK)
        columns = kind.columns(**{name: array[part] for name, array in values.items()})
        stream.send_columns(content.entity, [rr.TimeColumn(TIMELINE, duration=whole_ns[part])], columns, strict=True)


def write_whole(path: Path, content: bytes) -> None:
    """Write a file beside `path` and rename the file; a failure leaves no file. Raises InputError where refused."""
    with atomic_write(path) as part, system_errors_about(path):
        part.write_bytes(content)


def scalars(entity: str, time_s: Array, values: Array, names: Sequence[str], colours: Sequence[str]) -> Content:
    """Return a series (n,) or (n, k), a row per sample."""
    lines = rr.SeriesLines(names=list(names), colors=[rgb(c) for c in colours])
    return Content(entity, lines, Rows(time_s, rr.Scalars, {"scalars": values}))


def vectors(entity: str, time_s: Array, values: Array) -> Content:
    """Return a series of vectors (n, 3), a row per sample."""
    return scalars(entity, time_s, values, "xyz", XYZ)


def text(words: str) -> Content:
    """Return notes in Markdown."""
    return Content("notes", rr.TextDocument(words, media_type="text/markdown"))


def entity_name(name: str) -> str:
    """Return a name as part of an entity path."""
    return str(rr.escape_entity_path_part(name))


def time_view(name: str, time_s: Array, *contents: str, low: float | None = None) -> rrb.TimeSeriesView:
    """Return a plot over the whole time; the value axis is symmetric from `low` (below 0), if given."""
    whole = rr.TimeRange(*(rr.TimeRangeBoundary.absolute(seconds=float(t)) for t in (time_s[0], time_s[-1])))
    axis_y = {} if low is None else {"axis_y": rrb.ScalarAxis(range=(low, -low), zoom_lock=False)}
    axis_x = rrb.TimeAxis(view_range=whole)
    legend = rrb.PlotLegend(corner=rrb.Corner2D.RightTop)  # by default the legend lies over the axis' ticks
    return rrb.TimeSeriesView(
        origin="/", contents=list(contents), name=name, axis_x=axis_x, plot_legend=legend, **axis_y
    )


def gap_views(gap: GapSeries, entity: str, after: str, name: str) -> rrb.Grid:
    """Return plots of a gap before and after, one below the other, with a common symmetric value axis.

    after : what the gap afterwards is based on, in words.
    """
    low = (
        -1.5 * float(np.nanmax(np.abs(block_means(gap.before_nT, block_length(len(gap.time_s), MOST_BLOCKS))))) or None
    )
    names = {"before": "the model as given", "after": after}
    views = [time_view(f"{text} (nT)", gap.time_s, f"{entity}/{side}", low=low) for side, text in names.items()]
    return rrb.Grid(*views, grid_columns=1, name=name)


def layout(*parts: Any) -> rrb.Blueprint:
    """Return a layout with its side panels folded."""
    return rrb.Blueprint(
        *parts,
        rrb.TimePanel(timeline=TIMELINE, state="collapsed", play_state="paused", playback_speed=10.0),
        rrb.BlueprintPanel(state="collapsed"),
        rrb.SelectionPanel(state="collapsed"),
        auto_views=False,
    )


def camera_at(pos_m: Array, least_m: float) -> rrb.EyeControls3D:
    """Return a camera with all positions (n, 3) in view."""
    low, high = np.nanmin(pos_m, axis=0), np.nanmax(pos_m, axis=0)
    away = max(least_m, float(np.linalg.norm(high - low))) * np.array([-0.5, -0.65, 0.5])
    return rrb.EyeControls3D(position=(low + high) / 2 + away, look_target=(low + high) / 2)
