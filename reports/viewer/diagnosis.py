"""The rerun recording of a diagnosis: measured beside simulated, the gap before and after, over time and path."""

from __future__ import annotations

import zlib

import numpy as np
import rerun as rr
import rerun.blueprint as rrb

from diagnosis.evidence.localise import channels
from diagnosis.result import Diagnosis
from reports.gap_series import (
    MOST_BLOCKS,
    GapAlongPath,
    block_length,
    block_means,
    compared_series,
    gap_along_path,
    has_path,
    hidden_by_iron_refit,
    relative_to_first,
)
from reports.palette import LINES, RAW, XYZ, rgb
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
BEFORE, AFTER = LINES[1], LINES[0]
LOW, HIGH = (86, 180, 233), (213, 60, 0)
"""Colours of the smallest and the largest gap along the path."""
PLACE, VEHICLE = "world/place", "world/place/vehicle"
Series = dict[str, Array]


def diagnosis_recording(found: Diagnosis, title: str) -> bytes:
    """The recording as the bytes of an .rrd file with its layout.

    On the timeline `time` (seconds since the first sample), one row a sample, means over blocks beyond MOST_ROWS:
    `mag`, `simulated/before`, `simulated/after` (the models as they stand, along the measured motion), `difference/…`
    (measured minus these) and `residual/…` (the same with hard and soft iron fitted anew: what the verdict rests on),
    x, y, z in nT, body frame; without attitude `mag`, and `strength/measured`, `strength/before`, `strength/after`,
    `residual/…` as one value; with roll and pitch `dip/…` too, and `residual/…` as two. `channel/<name>`: what the gap
    goes with. Where recorded, `world`: path (m, ENU, from its first point), attitude, and the gap along them. What is
    no measurement (a spike) is left out of the gap.
    """
    length = block_length(len(found.problem.recording), MOST_ROWS)
    series, where = _series(found), gap_along_path(found)

    def fill(stream: rr.RecordingStream) -> None:
        stream.send_recording_name(title)
        send_static(stream, "notes", rr.TextDocument(_notes(found, length), media_type="text/markdown"))
        time_s = block_means(found.problem.state.time_s, length)
        for name, values in series.items():
            usable = found.problem.usable if name.startswith(("residual/", "strength/", "dip/")) else None
            labels, colours = _style(name, values)
            send_scalars(stream, name, time_s, block_means(values, length, usable), labels, colours)
        _send_space(stream, found, where)

    # The viewer keeps a layout by this name: one a diagnosis, so that none opens with another's.
    name = f"diagnosis_{zlib.crc32(found.before_nT.tobytes()):08x}"
    return recording_bytes(name, _blueprint(found, where, series), fill)


def _series(found: Diagnosis) -> Series:
    """Every series by its entity, at full length."""
    both, problem = compared_series(found), found.problem
    gap = {"residual/before": found.before_nT, "residual/after": found.after_nT}
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
    goes_with = {f"channel/{entity_name(name)}": every[name] for name, _, _ in found.where if name in every}
    return compared | gap | goes_with


def _style(name: str, values: Array) -> tuple[list[str], tuple[str, ...]]:
    if values.ndim == 2 and values.shape[1] == 3:
        return ["x", "y", "z"], XYZ
    if values.ndim == 2 and values.shape[1] == 2:
        return ["strength", "dip"], XYZ[:2]
    kind = name.rpartition("/")[2]
    return [kind], ({"before": BEFORE, "after": AFTER, "measured": RAW}.get(kind, LINES[2]),)


# in space


def _send_space(stream: rr.RecordingStream, found: Diagnosis, where: GapAlongPath) -> None:
    recording = found.problem.recording
    keep = every_nth(len(recording), MOST_POSES)
    time_s = found.problem.state.time_s[keep]
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
    """The gap as arrows of the vehicle, before and after to one scale: the largest usual gap is one axis long."""
    full = _usual(where.before_nT)
    for name, gap, colour in (("before", where.before_nT, BEFORE), ("after", where.after_nT, AFTER)):
        if gap.shape[1] == 3:
            send_static(stream, f"{VEHICLE}/gap/{name}", rr.Arrows3D.from_fields(colors=rgb(colour), radii=0.02))
            vectors = np.nan_to_num(gap) / full
            send_columns(stream, f"{VEHICLE}/gap/{name}", where.time_s, rr.Arrows3D.columns(vectors=vectors))


def _usual(gap_nT: Array) -> float:
    """The size that few gaps (m, q) exceed, above zero."""
    size = np.linalg.norm(gap_nT, axis=1)
    size = size[np.isfinite(size)]
    return max(float(np.quantile(size, 0.98)) if len(size) else 0.0, 1e-9)


# layout and words


def _blueprint(found: Diagnosis, where: GapAlongPath, series: Series) -> rrb.Blueprint:
    notes = rrb.TextDocumentView(origin="notes", name="Diagnosis")
    bottom = rrb.Horizontal(rrb.Tabs(*_plots(found, series), active_tab=0), notes, column_shares=[3, 2])
    spaces = _spaces(found, where)
    return layout(rrb.Vertical(rrb.Horizontal(*spaces), bottom, row_shares=[2, 3]) if spaces else bottom)


def _spaces(found: Diagnosis, where: GapAlongPath) -> list[rrb.Spatial3DView]:
    views = []
    if where.pos_m is not None and has_path(where):
        eye = camera_at(where.pos_m, 1.0)
        for name in ("before", "after"):
            contents = ["world/path", f"world/gap/{name}", f"{PLACE}/here"]
            title = f"Gap {name} along the path (blue small, red large)"
            view = rrb.Spatial3DView(origin="world", contents=contents, name=title, line_grid=False, eye_controls=eye)
            views.append(view)
    if found.problem.recording.att_q is not None:
        eye = rrb.EyeControls3D(position=(-1.6, -2.1, 1.3), look_target=(0, 0, 0))
        title = "Body axes; gap before (red), after (blue), enlarged"
        around = [f"{VEHICLE}/**"]
        views.append(rrb.Spatial3DView(origin=PLACE, contents=around, name=title, line_grid=False, eye_controls=eye))
    return views


def _plots(found: Diagnosis, series: Series) -> list[rrb.Grid | rrb.TimeSeriesView]:
    time_s = found.problem.state.time_s

    def pair(kind: str, title: str) -> rrb.Grid:
        low = _lowest(series[f"{kind}/before"])
        names = {"before": "the model as given", "after": "the new model"}
        views = [time_view(f"{text} (nT)", time_s, f"{kind}/{part}", low=low) for part, text in names.items()]
        return rrb.Grid(*views, grid_columns=1, name=title)

    vector = found.problem.mode == "vector"
    tabs = [pair("residual", "Gap, iron fitted anew")]
    tabs += [pair("difference", "Gap as the models stand")] if vector else []
    tabs = tabs[::-1] if hidden_by_iron_refit(found) else tabs
    together = [("mag", "simulated/**")] if vector else [(f"{one}/**",) for one in found.problem.outputs]
    views = [time_view("Measured and simulated (nT)", time_s, *each) for each in together]
    tabs.append(views[0] if len(views) == 1 else rrb.Grid(*views, grid_columns=1, name="Measured and simulated (nT)"))
    beside = [time_view(name.partition("/")[2], time_s, name) for name in series if name.startswith("channel/")]
    return [*tabs, *([rrb.Grid(*beside, grid_columns=2, name="Channels it goes with")] if beside else [])]


def _lowest(gap_nT: Array) -> float | None:
    """Where the value axis of a gap (n, q) begins, so that before and after have one scale."""
    thin = block_means(gap_nT, block_length(len(gap_nT), MOST_BLOCKS))
    return -1.5 * float(np.abs(thin).max()) or None


def _notes(found: Diagnosis, length: int) -> str:
    lines = [f"# {found.verdict}", "", found.sentence, "", *(f"- {line}" for line in found.advice), ""]
    lines += ["| gap, rms | before (nT) | after (nT) | explained |", "| --- | --- | --- | --- |"]
    lines += [f"| {row[0]} | {row[1]} | {row[2]} | {row[-1]} |" for row in gap_rows(found)]
    lines += [""]
    if found.where:
        lines += ["| channel | frame | share of the slow gap |", "| --- | --- | --- |"]
        lines += [f"| {name} | {frame} | {100 * score:.0f} % |" for name, frame, score in found.where]
    if length > 1:
        lines += ["", f"Thinned: each point is the mean of {length} samples."]
    return "\n".join(lines) + "\n"
