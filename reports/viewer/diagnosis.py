"""Rerun recording of a diagnosis: measured and simulated, gap before and after, over time and along the path."""

from __future__ import annotations

import zlib

import numpy as np
import rerun as rr
import rerun.blueprint as rrb

from diagnosis.evidence.localise import channels
from diagnosis.result import Diagnosis
from reports.gap_series import (
    GapAlongPath,
    block_length,
    block_means,
    compared_series,
    gap_along_path,
    has_path,
    hidden_by_iron_refit,
    relative_to_first,
    value_axis_low,
)
from reports.palette import AFTER, BEFORE, LINES, RAW, XYZ, rgb
from reports.text.diagnosis import gap_rows
from reports.viewer.stream import (
    MOST_POSES,
    camera_at,
    entity_name,
    layout,
    recording_bytes,
    send_columns,
    send_scalars,
    send_static,
    time_view,
)
from scenarios.arrays import Array
from validation.signals.thinning import every_nth

MOST_ROWS = 100_000
LOW, HIGH = (86, 180, 233), (213, 60, 0)
"""Colours of the smallest and the largest gap along the path."""
PLACE, VEHICLE = "world/place", "world/place/vehicle"
Series = dict[str, Array]


def diagnosis_recording(diagnosis: Diagnosis, title: str) -> bytes:
    """Return the recording with its layout as the bytes of an .rrd file.

    Timeline `time`: seconds since the first sample, one row per sample, block means beyond MOST_ROWS. Body axes in nT:
    `mag`; `simulated/before`, `simulated/after`: models along the measured motion; `difference/…`: measured minus
    simulated; `residual/…`: the difference with hard and soft iron refitted, basis of the verdict. Without attitude:
    `mag`, and as scalars `strength/measured`, `strength/before`, `strength/after`, `residual/…`; with roll and pitch
    also `dip/…`, and `residual/…` as two values. `channel/<name>`: channels that the gap follows. `world`, where
    recorded: path (m, ENU, from the first point), attitude, and the gap along the path. Unusable samples
    (spikes) are left out of the gap.
    """
    length = block_length(len(diagnosis.problem.recording), MOST_ROWS)
    series, where = _series(diagnosis), gap_along_path(diagnosis)

    def fill(stream: rr.RecordingStream) -> None:
        stream.send_recording_name(title)
        send_static(stream, "notes", rr.TextDocument(_notes(diagnosis, length), media_type="text/markdown"))
        time_s = block_means(diagnosis.problem.state.time_s, length)
        for name, values in series.items():
            usable = diagnosis.problem.usable if name.startswith(("residual/", "strength/", "dip/")) else None
            labels, colours = _style(name, values)
            send_scalars(stream, name, time_s, block_means(values, length, usable), labels, colours)
        _send_space(stream, diagnosis, where)

    # The viewer keeps a layout by this name: one a diagnosis, so that none opens with another's.
    name = f"diagnosis_{zlib.crc32(diagnosis.before_nT.tobytes()):08x}"
    return recording_bytes(name, _blueprint(diagnosis, where, series), fill)


def _series(diagnosis: Diagnosis) -> Series:
    """Return every series at full length, by entity."""
    both, problem = compared_series(diagnosis), diagnosis.problem
    gap = {"residual/before": diagnosis.before_nT, "residual/after": diagnosis.after_nT}
    if problem.mode == "vector":
        compared = {
            "mag": both.measured_nT,
            "simulated/before": both.before_nT,
            "simulated/after": both.after_nT,
            "difference/before": both.measured_nT - both.before_nT,
            "difference/after": both.measured_nT - both.after_nT,
        }
    else:
        parts = {"measured": both.measured_nT, "before": both.before_nT, "after": both.after_nT}
        compared = {"mag": problem.recording.mag_nT} | {
            f"{output}/{name}": values[:, a : a + 1]
            for a, output in enumerate(problem.outputs)
            for name, values in parts.items()
        }
    every = dict(channels(problem))
    goes_with = {f"channel/{entity_name(name)}": every[name] for name, _, _ in diagnosis.where if name in every}
    return compared | gap | goes_with


def _style(name: str, values: Array) -> tuple[list[str], tuple[str, ...]]:
    if values.ndim == 2 and values.shape[1] == 3:
        return ["x", "y", "z"], XYZ
    if values.ndim == 2 and values.shape[1] == 2:
        return ["strength", "dip"], XYZ[:2]
    kind = name.rpartition("/")[2]
    return [kind], ({"before": BEFORE, "after": AFTER, "measured": RAW}.get(kind, LINES[2]),)


# in space


def _send_space(stream: rr.RecordingStream, diagnosis: Diagnosis, where: GapAlongPath) -> None:
    recording = diagnosis.problem.recording
    keep = every_nth(len(recording), MOST_POSES)
    time_s = diagnosis.problem.state.time_s[keep]
    send_static(stream, "world", rr.ViewCoordinates.RIGHT_HAND_Z_UP)
    if recording.pos_enu_m is not None and has_path(where):
        pos_m = relative_to_first(recording.pos_enu_m)[keep]
        strip = rr.LineStrips3D([pos_m], colors=rgb(RAW), radii=rr.Radius.ui_points(0.5))
        send_static(stream, "world/path", strip)
        send_columns(stream, PLACE, time_s, rr.Transform3D.columns(translation=pos_m))
        here = rr.Points3D([[0, 0, 0]], radii=rr.Radius.ui_points(6), colors=rgb(LINES[4]))
        send_static(stream, f"{PLACE}/here", here)
        _send_gap_on_path(stream, where)
    if recording.att_q is not None:
        q = recording.att_q[keep][:, [1, 2, 3, 0]]
        send_columns(stream, VEHICLE, time_s, rr.Transform3D.columns(quaternion=q))
        body = rr.Arrows3D(vectors=np.eye(3), colors=[rgb(c) for c in XYZ], labels=["x", "y", "z"], radii=0.015)
        send_static(stream, f"{VEHICLE}/axes", body)
        _send_gap_arrows(stream, where)


def _send_gap_on_path(stream: rr.RecordingStream, where: GapAlongPath) -> None:
    assert where.pos_m is not None
    full = _usual(where.before_nT)
    for name, gap in (("before", where.before_nT), ("after", where.after_nT)):
        size = np.linalg.norm(gap, axis=1)
        whole = np.isfinite(size)
        share = np.clip(size[whole] / full, 0, 1)[:, None]
        colours = np.round((1 - share) * LOW + share * HIGH).astype(np.uint8)
        dots = rr.Points3D(where.pos_m[whole], colors=colours, radii=rr.Radius.ui_points(3))
        send_static(stream, f"world/gap/{name}", dots)


def _send_gap_arrows(stream: rr.RecordingStream, where: GapAlongPath) -> None:
    """Send the gap as arrows in the body frame, before and after to one scale: the 98 % quantile is one axis long."""
    full = _usual(where.before_nT)
    for name, gap, colour in (("before", where.before_nT, BEFORE), ("after", where.after_nT, AFTER)):
        if gap.shape[1] == 3:
            send_static(stream, f"{VEHICLE}/gap/{name}", rr.Arrows3D.from_fields(colors=rgb(colour), radii=0.02))
            vectors = np.nan_to_num(gap) / full
            send_columns(stream, f"{VEHICLE}/gap/{name}", where.time_s, rr.Arrows3D.columns(vectors=vectors))


def _usual(gap_nT: Array) -> float:
    """Return the 98 % quantile of the size of gaps (m, q), above zero."""
    size = np.linalg.norm(gap_nT, axis=1)
    size = size[np.isfinite(size)]
    return max(float(np.quantile(size, 0.98)) if len(size) else 0.0, 1e-9)


# layout and words


def _blueprint(diagnosis: Diagnosis, where: GapAlongPath, series: Series) -> rrb.Blueprint:
    notes = rrb.TextDocumentView(origin="notes", name="Diagnosis")
    bottom = rrb.Horizontal(rrb.Tabs(*_plots(diagnosis, series), active_tab=0), notes, column_shares=[3, 2])
    spaces = _spaces(diagnosis, where)
    return layout(rrb.Vertical(rrb.Horizontal(*spaces), bottom, row_shares=[2, 3]) if spaces else bottom)


def _spaces(diagnosis: Diagnosis, where: GapAlongPath) -> list[rrb.Spatial3DView]:
    views = []
    if where.pos_m is not None and has_path(where):
        eye = camera_at(where.pos_m, 1.0)
        for name in ("before", "after"):
            contents = ["world/path", f"world/gap/{name}", f"{PLACE}/here"]
            title = f"Gap {name} along the path (blue small, red large)"
            view = rrb.Spatial3DView(origin="world", contents=contents, name=title, line_grid=False, eye_controls=eye)
            views.append(view)
    if diagnosis.problem.recording.att_q is not None:
        eye = rrb.EyeControls3D(position=(-1.6, -2.1, 1.3), look_target=(0, 0, 0))
        title = "Body axes; gap before (red), after (blue), enlarged"
        around = [f"{VEHICLE}/**"]
        views.append(rrb.Spatial3DView(origin=PLACE, contents=around, name=title, line_grid=False, eye_controls=eye))
    return views


def _plots(diagnosis: Diagnosis, series: Series) -> list[rrb.Grid | rrb.TimeSeriesView]:
    time_s = diagnosis.problem.state.time_s

    def pair(kind: str, title: str) -> rrb.Grid:
        low = value_axis_low(series[f"{kind}/before"])
        names = {"before": "the model as given", "after": "the new model"}
        views = [time_view(f"{text} (nT)", time_s, f"{kind}/{part}", low=low) for part, text in names.items()]
        return rrb.Grid(*views, grid_columns=1, name=title)

    vector = diagnosis.problem.mode == "vector"
    tabs = [pair("residual", "Gap, iron refitted")]
    tabs += [pair("difference", "Gap, models without refit")] if vector else []
    tabs = tabs[::-1] if hidden_by_iron_refit(diagnosis) else tabs
    together = [("mag", "simulated/**")] if vector else [(f"{one}/**",) for one in diagnosis.problem.outputs]
    views = [time_view("Measured and simulated (nT)", time_s, *each) for each in together]
    tabs.append(views[0] if len(views) == 1 else rrb.Grid(*views, grid_columns=1, name="Measured and simulated (nT)"))
    beside = [time_view(name.partition("/")[2], time_s, name) for name in series if name.startswith("channel/")]
    return [*tabs, *([rrb.Grid(*beside, grid_columns=2, name="Channels that the gap follows")] if beside else [])]


def _notes(diagnosis: Diagnosis, length: int) -> str:
    lines = [f"# {diagnosis.verdict}", "", diagnosis.sentence, "", *(f"- {line}" for line in diagnosis.advice), ""]
    lines += ["| gap, rms | before (nT) | after (nT) | explained |", "| --- | --- | --- | --- |"]
    lines += [f"| {row[0]} | {row[1]} | {row[2]} | {row[-1]} |" for row in gap_rows(diagnosis)]
    lines += [""]
    if diagnosis.where:
        lines += ["| channel | frame | share of the slow gap |", "| --- | --- | --- |"]
        lines += [f"| {name} | {frame} | {100 * score:.0f} % |" for name, frame, score in diagnosis.where]
    if length > 1:
        lines += ["", f"Thinned: each point is the mean of {length} samples."]
    return "\n".join(lines) + "\n"
