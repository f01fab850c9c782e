"""The rerun recording of one outcome: vehicle in motion, field on its sphere, every series at full resolution."""

from __future__ import annotations

import subprocess
from importlib import resources
from pathlib import Path
from typing import Any

import numpy as np
import rerun as rr
import rerun.blueprint as rrb
from rerun.chunk import RrdReader

from scenarios.errors import InputError
from sim.dataset.files import beside, told
from validation.outcome import Array, Outcome, envelope, every_nth
from validation.palette import LINES, RAW, XYZ, phase_colours, rgb
from validation.shapes import gimbals, reach_m, solids
from validation.wording import notes_markdown

TIMELINE, SCALARS = "time", "Scalars:scalars"
ROWS_A_CHUNK = 65_536
TRUE, MEASURED, DIFFERENCE = LINES[5], LINES[1], LINES[3]
"""Colours that show on the viewer's dark and on its light ground."""
MOST_POSES, MOST_POINTS, THIN_BUCKETS = 20_000, 20_000, 25_000
PLACE, VEHICLE = "world/place", "world/place/vehicle"
"""The frame that moves with the vehicle but does not turn, so that a view of it follows; and the vehicle's own."""


def write_recording(outcome: Outcome, path: Path) -> None:
    """Write the recording as one .rrd file with its layout.

    On the timeline `time` (seconds since the start of the run), each an entity of one row a sample:
    `mag`, `true_field`, `effects/<name>`, `corrected/<calibrator>` (x, y, z in nT, body frame), `current` (A) and
    `temperature` (degC) in float64 at full resolution; thinned by least and greatest value beyond 50 000 samples:
    `norm/<what>`, `residual/<calibrator>` (see Outcome.residual_nT). In space, at most 20 000 poses: `world` (m, ENU)
    and `cloud` (nT, body frame). Of an array it shows sensor 1.

    The file is made in memory, written beside `path` and renamed; on failure nothing is left.
    Raises InputError where it cannot be written.
    """
    stream = rr.RecordingStream(f"magbench_{outcome.scenario.name}")
    # rerun's own file writer does not say that a disk is full: it waits for ever, or leaves the file without its end.
    memory = stream.memory_recording()
    if stream.get_application_id() is None:
        raise InputError("turns recordings off", where="environment variable RERUN", do="unset it")
    try:
        stream.send_blueprint(_blueprint(outcome), make_active=False, make_default=True)
        _send_properties(stream, outcome)
        _send_world(stream, outcome)
        _send_clouds(stream, outcome)
        _send_series(stream, outcome)
        whole = memory.drain_as_bytes()
    finally:
        stream.disconnect()
    with beside(path) as part, told(path):
        part.write_bytes(whole)


def read_series(path: Path, entity: str) -> tuple[Array, Array]:
    """A series of a recording: times (n,) in s, to the nanosecond, and values (n,) or (n, k) as written.

    Raises InputError when the recording has no such series; the message lists those it has.
    """
    store = RrdReader(path).store()
    found = [c.entity_path for c in store.schema().component_columns() if c.component == SCALARS]
    series = {name.replace("\\", "").strip("/"): name for name in found}
    if entity.strip("/") not in series:
        raise InputError(f"no series {entity!r}", where=str(path), do=f"there are: {', '.join(sorted(series))}")
    chunks = store.stream().filter(content=series[entity.strip("/")], components=SCALARS, is_static=False).to_chunks()
    parts = [_columns(chunk.to_record_batch()) for chunk in chunks]
    time_ns, values = np.concatenate([p[0] for p in parts]), np.concatenate([p[1] for p in parts])
    order = np.argsort(time_ns, kind="stable")
    return time_ns[order] / 1e9, values[order]


def _columns(batch: Any) -> tuple[Any, Array]:
    time_ns = batch.column(TIMELINE).to_numpy(zero_copy_only=False).astype("timedelta64[ns]").astype(np.int64)
    flat = batch.column(SCALARS).flatten().to_numpy()
    return time_ns, flat if len(flat) == len(time_ns) else flat.reshape(len(time_ns), -1)


def viewer_program() -> Path:
    """The program that rerun's package brings: viewer and file tools (its `rerun` script is only a launcher)."""
    folder = Path(str(resources.files("rerun_cli")))
    places = (folder / "rerun", folder / "rerun.exe", folder / "Rerun.app/Contents/MacOS/Rerun")
    return next(place for place in places if place.exists())


def verify(path: Path) -> None:
    """Check with rerun's own command that a recording can be read; InputError says what is wrong with it."""
    command = [str(viewer_program()), "rrd", "verify", str(path)]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    if done.returncode:
        reason = next(
            (line for line in done.stderr.splitlines() if "rror" in line or path.name in line), "cannot be read"
        )
        raise InputError(reason.strip(), where=str(path), do="write the recording again")


def _send_properties(stream: rr.RecordingStream, outcome: Outcome) -> None:
    scenario = outcome.scenario
    stream.send_recording_name(f"{scenario.name}, seed {scenario.seed}")
    about = rr.AnyValues(name=scenario.name, summary=scenario.summary, seed=scenario.seed, sensors=outcome.sensors)
    stream.send_property("scenario", about)
    _static(stream, "notes", rr.TextDocument(notes_markdown(outcome), media_type="text/markdown"))


def _static(stream: rr.RecordingStream, entity: str, *archetypes: Any) -> None:
    stream.log(entity, *archetypes, static=True, strict=True)


def _send(stream: rr.RecordingStream, entity: str, time_s: Array, columns: Any) -> None:
    whole_ns = np.round(1e9 * time_s).astype("timedelta64[ns]")  # given seconds, rerun would cut, not round
    stream.send_columns(entity, [rr.TimeColumn(TIMELINE, duration=whole_ns)], columns, strict=True)


# the vehicle in space


def _send_world(stream: rr.RecordingStream, outcome: Outcome) -> None:
    _static(stream, "world", rr.ViewCoordinates.RIGHT_HAND_Z_UP)
    colours = phase_colours(outcome)
    for k, (label, first, last) in enumerate(outcome.phases()):
        pos_m = outcome.truth.pos_enu_m[first : last + 1]
        strip = rr.LineStrips3D(
            [pos_m[every_nth(len(pos_m), MOST_POSES)]],
            colors=rgb(colours[label]),
            radii=rr.Radius.ui_points(1.5),
            labels=label,
        )
        _static(stream, f"world/path/{k:03d}_{label}", strip)
    keep = every_nth(len(outcome.recording), MOST_POSES)
    _send_vehicle(stream, outcome, keep)
    _send_arrows(stream, outcome, keep)


def _send_vehicle(stream: rr.RecordingStream, outcome: Outcome, keep: slice) -> None:
    time_s, pos_m, q = outcome.recording.time_s[keep], outcome.truth.pos_enu_m[keep], outcome.truth.q[keep]
    for solid in solids(outcome.scenario.vehicle.kind):
        mesh = rr.Mesh3D(
            vertex_positions=solid.corners_m, vertex_normals=solid.normals, albedo_factor=solid.colour,
            triangle_indices=np.arange(len(solid.corners_m)).reshape(-1, 3),
        )  # fmt: skip
        _static(stream, f"{PLACE}/{solid.carrier}/{solid.name}", mesh)
    frames = {"vehicle": q} | (gimbals(q) if outcome.scenario.vehicle.kind == "turntable" else {})
    _send(stream, PLACE, time_s, rr.Transform3D.columns(translation=pos_m))
    for name, quaternion in frames.items():
        _send(stream, f"{PLACE}/{name}", time_s, rr.Transform3D.columns(quaternion=quaternion[:, [1, 2, 3, 0]]))
    here = rr.Points3D([[0, 0, 0]], radii=rr.Radius.ui_points(5), colors=rgb(LINES[4]))
    _static(stream, f"{PLACE}/here", here)


def _send_arrows(stream: rr.RecordingStream, outcome: Outcome, keep: slice) -> None:
    """True and measured field as arrows of the vehicle, and their difference drawn to a scale of its own."""
    reach = reach_m(outcome.scenario.vehicle.kind)
    true_nT, mag_nT = outcome.truth.field_nT[keep], outcome.recording.mag_nT[keep]
    wrong_nT = mag_nT - true_nT
    scale, usual = 1.6 * reach / outcome.field_strength_nT, float(np.nanmedian(np.linalg.norm(wrong_nT, axis=1)))
    arrows = {
        "true_field": (scale * true_nT, TRUE),
        "measured": (scale * mag_nT, MEASURED),
        "disturbance": (wrong_nT * (0.8 * reach / usual if usual > 0 else 0.0), DIFFERENCE),
    }
    for name, (vectors, colour) in arrows.items():
        style = rr.Arrows3D.from_fields(colors=rgb(colour), radii=0.018 * reach)
        _static(stream, f"{VEHICLE}/field/{name}", style)
        _send(stream, f"{VEHICLE}/field/{name}", outcome.recording.time_s[keep], rr.Arrows3D.columns(vectors=vectors))


def _send_clouds(stream: rr.RecordingStream, outcome: Outcome) -> None:
    _static(stream, "cloud", rr.ViewCoordinates.RIGHT_HAND_Z_UP)
    radius = outcome.field_strength_nT
    sphere = rr.Ellipsoids3D(half_sizes=[[radius] * 3], colors=(150, 158, 166, 90), line_radii=rr.Radius.ui_points(0.5))
    _static(stream, "cloud/reference", sphere)
    clouds = {
        "raw": outcome.recording.mag_nT,
        **{f"corrected/{_part(n)}": outcome.corrected[n] for n in outcome.shown()},
    }
    keep = every_nth(len(outcome.recording), MOST_POINTS)
    for (name, cloud), colour in zip(clouds.items(), _cycle(len(clouds)), strict=True):
        points = rr.Points3D(cloud[keep], radii=rr.Radius.ui_points(1.5), colors=rgb(colour))
        _static(stream, f"cloud/{name}", points)
    now = rr.Points3D.from_fields(radii=rr.Radius.ui_points(6), colors=rgb(LINES[4]))
    _static(stream, "cloud/now", now)
    columns = rr.Points3D.columns(positions=outcome.recording.mag_nT[keep])
    _send(stream, "cloud/now", outcome.recording.time_s[keep], columns)


# series


def _send_series(stream: rr.RecordingStream, outcome: Outcome) -> None:
    recording, truth = outcome.recording, outcome.truth
    _xyz(stream, "mag", recording.time_s, recording.mag_nT)
    _xyz(stream, "true_field", recording.time_s, truth.field_nT)
    for name, value in outcome.effects.items():
        _xyz(stream, f"effects/{_part(name)}", recording.time_s, value)
    for name, value in outcome.corrected.items():
        _xyz(stream, f"corrected/{_part(name)}", recording.time_s, value)
        _xyz(stream, f"residual/{_part(name)}", *envelope(recording.time_s, outcome.residual_nT(name), THIN_BUCKETS))
    fields = {"raw": recording.mag_nT, "truth": truth.field_nT, **{n: outcome.corrected[n] for n in outcome.shown()}}
    for (name, value), colour in zip(fields.items(), (RAW, TRUE, *_cycle(len(fields) - 1)[1:]), strict=True):
        norm = envelope(recording.time_s, np.linalg.norm(value, axis=1), THIN_BUCKETS)
        _scalars(stream, f"norm/{_part(name)}", *norm, [name], (colour,))
    if recording.temperature_degC is not None:
        _scalars(stream, "temperature", recording.time_s, recording.temperature_degC, ["temperature (°C)"], LINES[1:2])
    if recording.current_A is not None and recording.current_A.size:
        names = [f"motor {k + 1} (A)" for k in range(recording.current_A.shape[1])]
        _scalars(stream, "current", recording.time_s, recording.current_A, names, _cycle(len(names) + 1)[1:])


def _xyz(stream: rr.RecordingStream, entity: str, time_s: Array, values: Array) -> None:
    _scalars(stream, entity, time_s, values, ["x", "y", "z"], XYZ)


def _scalars(
    stream: rr.RecordingStream, entity: str, time_s: Array, values: Array, names: list[str], colours: tuple[str, ...]
) -> None:
    """A series (n,) or (n, k), one row a sample."""
    _static(stream, entity, rr.SeriesLines(names=names, colors=[rgb(c) for c in colours]))
    for first in range(0, len(time_s), ROWS_A_CHUNK):
        part = slice(first, first + ROWS_A_CHUNK)
        _send(stream, entity, time_s[part], rr.Scalars.columns(scalars=values[part]))


def _part(name: str) -> str:
    """A name as one part of an entity path."""
    return str(rr.escape_entity_path_part(name))


def _cycle(count: int) -> tuple[str, ...]:
    """Colours of `count` things: grey for the raw, then the palette round and round."""
    return (RAW, *(LINES[k % len(LINES)] for k in range(count)))[:count]


# layout


def _blueprint(outcome: Outcome) -> rrb.Blueprint:
    notes = rrb.TextDocumentView(origin="notes", name="Scores")
    top = rrb.Horizontal(*_spaces(outcome))
    bottom = rrb.Horizontal(rrb.Tabs(*_plots(outcome), active_tab=0), notes, column_shares=[3, 2])
    return rrb.Blueprint(
        rrb.Vertical(top, bottom, row_shares=[1, 1]),
        rrb.TimePanel(timeline=TIMELINE, state="collapsed", play_state="paused", playback_speed=10.0),
        rrb.BlueprintPanel(state="collapsed"),
        rrb.SelectionPanel(state="collapsed"),
        auto_views=False,
    )


def _spaces(outcome: Outcome) -> list[rrb.Spatial3DView]:
    reach, pos_m = reach_m(outcome.scenario.vehicle.kind), outcome.truth.pos_enu_m
    best = [f"cloud/corrected/{_part(name)}" for name in outcome.shown()[:1]]
    clouds = ["cloud/raw", "cloud/reference", "cloud/now", *best]
    low, high = np.nanmin(pos_m, axis=0), np.nanmax(pos_m, axis=0)
    far = rrb.EyeControls3D(
        position=(low + high) / 2 + max(reach, float(np.linalg.norm(high - low))) * np.array([-0.5, -0.65, 0.5]),
        look_target=(low + high) / 2,
    )
    near = rrb.EyeControls3D(position=reach * np.array([-2.0, -2.6, 1.2]), look_target=(0, 0, -0.3 * reach))
    legend = "Field: true (blue), measured (red), difference enlarged (pink)"
    body = rrb.Spatial3DView(
        origin=PLACE, contents=["world/**", f"- {PLACE}/here"], name=legend, line_grid=False, eye_controls=near
    )
    path = rrb.Spatial3DView(
        origin="world", contents=["world/path/**", f"{PLACE}/here"], name="Path", line_grid=False, eye_controls=far
    )
    cloud = rrb.Spatial3DView(
        origin="cloud", contents=clouds, name="Raw (grey), best corrected (blue), body frame, nT", line_grid=False
    )
    return [body, path, cloud] if outcome.travels else [body, cloud]


def _plots(outcome: Outcome) -> list[rrb.TimeSeriesView | rrb.Grid]:
    time_s = outcome.recording.time_s
    whole = rr.TimeRange(*(rr.TimeRangeBoundary.absolute(seconds=float(t)) for t in (time_s[0], time_s[-1])))

    def view(name: str, *contents: str) -> rrb.TimeSeriesView:
        axis = rrb.TimeAxis(view_range=whole)
        return rrb.TimeSeriesView(origin="/", contents=list(contents), name=name, axis_x=axis)

    residuals = [view(f"{n}: corrected − truth (nT)", f"residual/{_part(n)}") for n in outcome.shown()]
    effects = [view(f"{n} (nT)", f"effects/{_part(n)}") for n in outcome.effects]
    return [
        *_grid("Residuals", residuals),
        view("Strength (nT)", "norm/**"),
        view("Measured field (nT)", "mag"),
        *_grid("Effects", effects),
        *_grid("Vehicle data", [view("Motor current (A)", "current"), view("Temperature (°C)", "temperature")]),
    ]


def _grid(name: str, views: list[rrb.TimeSeriesView]) -> list[rrb.Grid]:
    """Views side by side, none for none."""
    return [rrb.Grid(*views, grid_columns=round(len(views) ** 0.5), name=name)] if views else []
