"""Rerun recording of a diagnosis: measured and simulated, gap before and after, over time and along the path."""

from __future__ import annotations

import zlib
from collections.abc import Iterator, Sequence
from itertools import chain

import numpy as np
import rerun as rr
import rerun.blueprint as rrb

from reports.palette import AFTER, BEFORE, LINES, RAW, XYZ, rgb
from reports.presentation.diagnosis import PresentedDiagnosis
from reports.presentation.series import DiagnosisSeries, GapSeries, block_length, block_means
from reports.viewer.stream import (
    MOST_POSES,
    Content,
    Rows,
    camera_at,
    entity_name,
    gap_views,
    layout,
    recording_bytes,
    scalars,
    text,
    time_view,
)
from scenarios.arrays import Array
from validation.signals.thinning import every_nth

MOST_ROWS = 100_000
LOW, HIGH = (86, 180, 233), (213, 60, 0)
"""Colours of the smallest and the largest gap along the path."""
PLACE, VEHICLE = "world/place", "world/place/vehicle"


def diagnosis_recording(found: PresentedDiagnosis, title: str) -> bytes:
    """Return the recording with its layout as the bytes of an .rrd file.

    Timeline `time`: seconds since the first sample, one row per sample, block means beyond MOST_ROWS. Body axes in nT:
    `mag`; `simulated/before`, `simulated/after`: models along the measured motion; `difference/…`: measured minus
    simulated; `residual/…`: the difference with hard and soft iron refitted, basis of the verdict. Without attitude:
    `mag`, and as scalars `strength/measured`, `strength/before`, `strength/after`, `residual/…`; with roll and pitch
    also `dip/…`, and `residual/…` as two values. `channel/<name>`: channels that the gap follows. `world`, where
    recorded: path (m, ENU, from the first point), attitude, and the gap along the path. Unusable samples
    (spikes) are left out of the gap.
    """
    # The viewer keeps a layout by this name: one a diagnosis, so that none opens with another's.
    name = f"diagnosis_{zlib.crc32(found.series.residual.before_nT.tobytes()):08x}"
    return recording_bytes(name, title, _blueprint(found.series), chain(_over_time(found), _in_space(found.series)))


def _over_time(found: PresentedDiagnosis) -> Iterator[Content]:
    time_s = found.series.time_s
    length = block_length(len(time_s), MOST_ROWS)
    yield text(_notes(found, length))
    for name, values in _by_entity(found.series).items():
        usable = found.series.residual.usable if name.startswith(("residual/", "strength/", "dip/")) else None
        yield scalars(name, block_means(time_s, length), block_means(values, length, usable), *_style(name, values))


def _by_entity(series: DiagnosisSeries) -> dict[str, Array]:
    """Return every series at full length, by entity."""
    values = {"mag": series.mag_nT}
    values |= {f"residual/{side}": gap for side, gap in series.residual.sides.items()}
    if series.vector:
        values |= {f"simulated/{side}": simulated for side, simulated in series.simulated.items()}
        values |= {f"difference/{side}": gap for side, gap in series.difference.sides.items()}
    else:
        for name, compared in ({"measured": series.measured_nT} | series.simulated).items():
            values |= {f"{output}/{name}": compared[:, [k]] for k, output in enumerate(series.outputs)}
    return values | {f"channel/{entity_name(name)}": channel for name, channel in series.channels.items()}


def _style(name: str, values: Array) -> tuple[Sequence[str], Sequence[str]]:
    if values.ndim == 2 and values.shape[1] > 1:
        return ("xyz", XYZ) if values.shape[1] == 3 else (("strength", "dip"), XYZ[:2])
    kind = name.rpartition("/")[2]
    return [kind], ({"before": BEFORE, "after": AFTER, "measured": RAW}.get(kind, LINES[2]),)


# in space


def _in_space(series: DiagnosisSeries) -> Iterator[Content]:
    keep, gap = every_nth(len(series.time_s), MOST_POSES), series.path.gap
    time_s = series.time_s[keep]
    yield Content("world", rr.ViewCoordinates.RIGHT_HAND_Z_UP)
    if series.pos_m is not None and series.path.pos_m is not None:
        path_m = series.pos_m[keep]
        yield Content("world/path", rr.LineStrips3D([path_m], colors=rgb(RAW), radii=rr.Radius.ui_points(0.5)))
        yield Content(PLACE, None, Rows(time_s, rr.Transform3D, {"translation": path_m}))
        here = rr.Points3D([[0, 0, 0]], radii=rr.Radius.ui_points(6), colors=rgb(LINES[4]))
        yield Content(f"{PLACE}/here", here)
        yield from _gap_on_path(gap, series.path.pos_m)
    if series.att_q is not None:
        body = rr.Arrows3D(vectors=np.eye(3), colors=[rgb(c) for c in XYZ], labels=["x", "y", "z"], radii=0.015)
        yield Content(VEHICLE, None, Rows(time_s, rr.Transform3D, {"quaternion": series.att_q[keep][:, [1, 2, 3, 0]]}))
        yield Content(f"{VEHICLE}/axes", body)
        yield from _gap_arrows(gap) if series.vector else ()


def _gap_on_path(gap: GapSeries, pos_m: Array) -> Iterator[Content]:
    full = _usual(gap.before_nT)
    for side, gap_nT in gap.sides.items():
        size = np.linalg.norm(gap_nT, axis=1)
        whole = np.isfinite(size)
        share = np.clip(size[whole] / full, 0, 1)[:, None]
        colours = np.round((1 - share) * LOW + share * HIGH).astype(np.uint8)
        yield Content(f"world/gap/{side}", rr.Points3D(pos_m[whole], colors=colours, radii=rr.Radius.ui_points(3)))


def _gap_arrows(gap: GapSeries) -> Iterator[Content]:
    """Yield the gap as arrows in the body frame, before and after to one scale: the 98 % quantile is one axis long."""
    full = _usual(gap.before_nT)
    for (side, gap_nT), colour in zip(gap.sides.items(), (BEFORE, AFTER), strict=True):
        style = rr.Arrows3D.from_fields(colors=rgb(colour), radii=0.02)
        values = {"vectors": np.nan_to_num(gap_nT) / full}
        yield Content(f"{VEHICLE}/gap/{side}", style, Rows(gap.time_s, rr.Arrows3D, values))


def _usual(gap_nT: Array) -> float:
    """Return the 98 % quantile of the size of gaps (m, q), above zero."""
    size = np.linalg.norm(gap_nT, axis=1)
    return max(float(np.nanquantile(size, 0.98)) if np.isfinite(size).any() else 0.0, 1e-9)


# layout and words


def _blueprint(series: DiagnosisSeries) -> rrb.Blueprint:
    notes = rrb.TextDocumentView(origin="notes", name="Diagnosis")
    bottom = rrb.Horizontal(rrb.Tabs(*_plots(series), active_tab=0), notes, column_shares=[3, 2])
    spaces = _spaces(series)
    return layout(rrb.Vertical(rrb.Horizontal(*spaces), bottom, row_shares=[2, 3]) if spaces else bottom)


def _spaces(series: DiagnosisSeries) -> list[rrb.Spatial3DView]:
    views = []
    if series.path.pos_m is not None:
        eye = camera_at(series.path.pos_m, 1.0)
        for side in series.path.gap.sides:
            contents = ["world/path", f"world/gap/{side}", f"{PLACE}/here"]
            title = f"Gap {side} along the path (blue small, red large)"
            view = rrb.Spatial3DView(origin="world", contents=contents, name=title, line_grid=False, eye_controls=eye)
            views.append(view)
    if series.att_q is not None:
        eye = rrb.EyeControls3D(position=(-1.6, -2.1, 1.3), look_target=(0, 0, 0))
        title = "Body axes; gap before (red), after (blue), enlarged"
        around = [f"{VEHICLE}/**"]
        views.append(rrb.Spatial3DView(origin=PLACE, contents=around, name=title, line_grid=False, eye_controls=eye))
    return views


def _plots(series: DiagnosisSeries) -> list[rrb.Grid | rrb.TimeSeriesView]:
    time_s = series.time_s
    tabs = [gap_views(series.residual, "residual", "the new model", "Gap, iron refitted")]
    if series.vector:
        tabs.append(gap_views(series.difference, "difference", "the new model", "Gap, models without refit"))
    tabs = tabs[::-1] if series.hidden else tabs
    together = [("mag", "simulated/**")] if series.vector else [(f"{output}/**",) for output in series.outputs]
    views = [time_view("Measured and simulated (nT)", time_s, *each) for each in together]
    tabs.append(views[0] if len(views) == 1 else rrb.Grid(*views, grid_columns=1, name="Measured and simulated (nT)"))
    names = map(entity_name, series.channels)
    beside = [time_view(name, time_s, f"channel/{name}") for name in names]
    return [*tabs, *([rrb.Grid(*beside, grid_columns=2, name="Channels that the gap follows")] if beside else [])]


def _notes(found: PresentedDiagnosis, length: int) -> str:
    lines = [f"# {found.verdict}", "", found.sentence, "", *(f"- {line}" for line in found.advice), ""]
    lines += ["| gap, rms | before (nT) | after (nT) | explained |", "| --- | --- | --- | --- |"]
    lines += [f"| {row[0]} | {row[1]} | {row[2]} | {row[-1]} |" for row in found.gaps]
    lines += [""]
    if found.where:
        lines += ["| channel | frame | share of the slow gap |", "| --- | --- | --- |"]
        lines += [f"| {name} | {frame} | {100 * score:.0f} % |" for name, frame, score in found.where]
    if length > 1:
        lines += ["", f"Thinned: each point is the mean of {length} samples."]
    return "\n".join(lines) + "\n"
