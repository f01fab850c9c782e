"""Rerun recording of a run: vehicle in motion, field on the sphere, every series."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from itertools import chain, cycle, islice
from pathlib import Path

import numpy as np
import rerun as rr
import rerun.blueprint as rrb

from reports.palette import LINES, RAW, phase_colours, rgb
from reports.text.outcome import notes_markdown
from reports.viewer.stream import (
    DIFFERENCE,
    MEASURED,
    TRUE,
    Content,
    Rows,
    camera_at,
    entity_name,
    layout,
    recording_bytes,
    scalars,
    text,
    time_view,
    vectors,
    write_whole,
)
from reports.viewer.vehicle_mesh import radius_m, solids
from scenarios.arrays import Array
from sim.vehicles import vehicle_for
from sim.vehicles.base import Vehicle
from validation.scoring.outcome import Outcome
from validation.signals.thinning import envelope, every_nth


@dataclass(frozen=True)
class Detail:
    """Rows that a recording keeps of a series, and of poses, arrows and clouds in space."""

    samples: int
    poses: int

    def thinned(self, time_s: Array, values: Array) -> tuple[Array, Array]:
        """Return times and values of a series, thinned to least and greatest values where it is longer."""
        return envelope(time_s, values, self.samples // 2)


DRAWN = Detail(samples=8_000, poses=5_000)
"""More rows than a screen has columns, so that zooming in five times still shows every bucket."""
FULL = Detail(samples=2**40, poses=20_000)
PLACE, VEHICLE = "world/place", "world/place/vehicle"
"""The frame that moves with the vehicle but does not turn, so that a view of it follows; and the vehicle's own."""


def write_recording(outcome: Outcome, path: Path, detail: Detail = DRAWN) -> None:
    """Write the recording with its layout as an .rrd file.

    Timeline `time`: seconds since the start of the run. Entities with a row per sample, float64: `mag`, `true_field`,
    `effects/<name>`, `corrected/<calibrator>` (x, y, z in nT, body frame), `norm/<name>`, `residual/<calibrator>` (see
    Outcome.residual_nT), `current` (A), `temperature` (degC). In space: `world` (m, ENU) and `cloud` (nT, body frame).
    Of an array, sensor 1 is shown.

    detail : series beyond its samples are thinned to least and greatest values, poses to every nth; FULL keeps every
    sample.

    The file is made in memory, written beside `path` and renamed; a failure leaves no file. Raises InputError where the
    file cannot be written.
    """
    scenario = outcome.scenario
    about = rr.AnyValues(name=scenario.name, summary=scenario.summary, seed=scenario.seed, sensors=outcome.sensors)
    contents = chain(
        [text(notes_markdown(outcome))], _world(outcome, detail), _clouds(outcome, detail), _series(outcome, detail)
    )
    title = f"{scenario.name}, seed {scenario.seed}"
    write_whole(path, recording_bytes(scenario.name, title, _blueprint(outcome), contents, scenario=about))


# the vehicle in space


def _world(outcome: Outcome, detail: Detail) -> Iterator[Content]:
    yield Content("world", rr.ViewCoordinates.RIGHT_HAND_Z_UP)
    colours, radii = phase_colours(outcome), rr.Radius.ui_points(1.5)
    for k, (label, first, last) in enumerate(outcome.phases()):
        pos_m = outcome.truth.pos_enu_m[first : last + 1]
        path_m = pos_m[every_nth(len(pos_m), detail.poses)]
        strip = rr.LineStrips3D([path_m], colors=rgb(colours[label]), radii=radii, labels=label)
        yield Content(f"world/path/{k:03d}_{label}", strip)
    keep = every_nth(len(outcome.recording), detail.poses)
    yield from _vehicle(outcome, keep)
    yield from _arrows(outcome, keep)


def _vehicle(outcome: Outcome, keep: slice) -> Iterator[Content]:
    time_s, pos_m, q = outcome.recording.time_s[keep], outcome.truth.pos_enu_m[keep], outcome.truth.q[keep]
    vehicle = vehicle_for(outcome.scenario.vehicle)
    for solid in solids(vehicle):
        mesh = rr.Mesh3D(
            vertex_positions=solid.corners_m, vertex_normals=solid.normals, albedo_factor=solid.colour,
            triangle_indices=np.arange(len(solid.corners_m)).reshape(-1, 3),
        )  # fmt: skip
        yield Content(f"{_frame(vehicle, solid.body)}/{solid.name}", mesh)
    yield Content(PLACE, None, Rows(time_s, rr.Transform3D, {"translation": pos_m}))
    for body, turned in vehicle.turns(q).items():
        yield Content(
            _frame(vehicle, body), None, Rows(time_s, rr.Transform3D, {"quaternion": turned[:, [1, 2, 3, 0]]})
        )
    here = rr.Points3D([[0, 0, 0]], radii=rr.Radius.ui_points(5), colors=rgb(LINES[4]))
    yield Content(f"{PLACE}/here", here)


def _frame(vehicle: Vehicle, body: str) -> str:
    """Return the entity that holds the solids of a body of the model."""
    return VEHICLE if body == vehicle.body else f"{PLACE}/{body}"


def _reach_m(outcome: Outcome) -> float:
    return radius_m(solids(vehicle_for(outcome.scenario.vehicle)))


def _arrows(outcome: Outcome, keep: slice) -> Iterator[Content]:
    """Yield true and measured field as arrows in the body frame, and the difference on a larger scale."""
    reach = _reach_m(outcome)
    true_nT, mag_nT = outcome.truth.field_nT[keep], outcome.recording.mag_nT[keep]
    wrong_nT = mag_nT - true_nT
    scale, usual = 1.6 * reach / outcome.field_strength_nT, float(np.nanmedian(np.linalg.norm(wrong_nT, axis=1)))
    arrows = {
        "true_field": (scale * true_nT, TRUE, 0.03),  # thick: the measured arrow shows beside it even where both agree
        "measured": (1.15 * scale * mag_nT, MEASURED, 0.014),
        "disturbance": (wrong_nT * (0.8 * reach / usual if usual > 0 else 0.0), DIFFERENCE, 0.018),
    }
    for name, (values, colour, radius) in arrows.items():
        style = rr.Arrows3D.from_fields(colors=rgb(colour), radii=radius * reach)
        time_s = outcome.recording.time_s[keep]
        yield Content(f"{VEHICLE}/field/{name}", style, Rows(time_s, rr.Arrows3D, {"vectors": values}))


def _clouds(outcome: Outcome, detail: Detail) -> Iterator[Content]:
    recording, radius = outcome.recording, outcome.field_strength_nT
    yield Content("cloud", rr.ViewCoordinates.RIGHT_HAND_Z_UP)
    sphere = rr.Ellipsoids3D(half_sizes=[[radius] * 3], colors=(150, 158, 166, 90), line_radii=rr.Radius.ui_points(0.5))
    yield Content("cloud/reference", sphere)
    corrected = {f"corrected/{entity_name(name)}": outcome.corrected[name] for name in outcome.shown()}
    keep = every_nth(len(recording), detail.poses)
    for (name, cloud), colour in zip(({"raw": recording.mag_nT} | corrected).items(), _cycle(), strict=False):
        yield Content(f"cloud/{name}", rr.Points3D(cloud[keep], radii=rr.Radius.ui_points(1.5), colors=rgb(colour)))
    now = rr.Points3D.from_fields(radii=rr.Radius.ui_points(6), colors=rgb(LINES[4]))
    yield Content("cloud/now", now, Rows(recording.time_s[keep], rr.Points3D, {"positions": recording.mag_nT[keep]}))


# series


def _series(outcome: Outcome, detail: Detail) -> Iterator[Content]:
    recording, time_s = outcome.recording, outcome.recording.time_s
    fields = {"mag": recording.mag_nT, "true_field": outcome.truth.field_nT}
    fields |= {f"effects/{entity_name(name)}": value for name, value in outcome.effects.items()}
    fields |= {f"corrected/{entity_name(name)}": value for name, value in outcome.corrected.items()}
    for entity, value in fields.items():
        yield vectors(entity, *detail.thinned(time_s, value))
    for name in outcome.corrected:
        yield vectors(f"residual/{entity_name(name)}", *detail.thinned(time_s, outcome.residual_nT(name)))
    yield from _strengths(outcome, detail)
    if recording.temperature_degC is not None:
        thin = detail.thinned(time_s, recording.temperature_degC)
        yield scalars("temperature", *thin, ["temperature (°C)"], LINES[1:2])
    if recording.current_A is not None and recording.current_A.size:
        names = [f"motor {k} (A)" for k in recording.motors]
        thin = detail.thinned(time_s, recording.current_A)
        yield scalars("current", *thin, names, list(islice(_cycle(), 1, len(names) + 1)))


def _strengths(outcome: Outcome, detail: Detail) -> Iterator[Content]:
    """Yield the strength of the raw, true and corrected fields."""
    recording, colours = outcome.recording, _cycle()
    corrected = {name: outcome.corrected[name] for name in outcome.shown()}
    fields = {"raw": recording.mag_nT, "truth": outcome.truth.field_nT} | corrected
    for name, value in fields.items():
        norm = detail.thinned(recording.time_s, np.linalg.norm(value, axis=1))
        colour = TRUE if name == "truth" else next(colours)
        yield scalars(f"norm/{entity_name(name)}", *norm, [name], [colour])


def _cycle() -> Iterator[str]:
    """Yield colours: grey for the raw field, then the palette in a cycle."""
    return chain((RAW,), cycle(LINES))


# layout


def _blueprint(outcome: Outcome) -> rrb.Blueprint:
    notes = rrb.TextDocumentView(origin="notes", name="Scores")
    top = rrb.Horizontal(*_spaces(outcome))
    bottom = rrb.Horizontal(rrb.Tabs(*_plots(outcome), active_tab=0), notes, column_shares=[3, 2])
    return layout(rrb.Vertical(top, bottom, row_shares=[1, 1]))


def _spaces(outcome: Outcome) -> list[rrb.Spatial3DView]:
    reach, pos_m = _reach_m(outcome), outcome.truth.pos_enu_m
    best = [f"cloud/corrected/{entity_name(name)}" for name in outcome.shown()[:1]]
    clouds = ["cloud/raw", "cloud/reference", "cloud/now", *best]
    near = rrb.EyeControls3D(position=reach * np.array([-2.0, -2.6, 1.2]), look_target=(0, 0, -0.3 * reach))
    legend = "Field: true (blue), measured (red, 15 % longer), difference enlarged (pink)"
    body = rrb.Spatial3DView(
        origin=PLACE, contents=["world/**", f"- {PLACE}/here"], name=legend, line_grid=False, eye_controls=near
    )
    path = rrb.Spatial3DView(
        origin="world",
        contents=["world/path/**", f"{PLACE}/here"],
        name="Path",
        line_grid=False,
        eye_controls=camera_at(pos_m[busiest(outcome)], reach),
    )
    cloud = rrb.Spatial3DView(
        origin="cloud", contents=clouds, name="Raw (grey), best corrected (blue), body frame, nT", line_grid=False
    )
    return [body, path, cloud] if outcome.travels else [body, cloud]


def busiest(outcome: Outcome) -> slice:
    """Return the samples of the phase in which the vehicle turns most, where a calibration is made; else all.

    The angle turned: int |w| dt, w the body rate.
    """
    rate_rad_s, time_s = outcome.recording.gyro_rad_s, outcome.recording.time_s
    if rate_rad_s is None or len(time_s) < 2:
        return slice(None)
    turned = np.linalg.norm(rate_rad_s, axis=1) * np.gradient(time_s)
    _, first, last = max(outcome.phases(), key=lambda phase: float(np.nansum(turned[phase[1] : phase[2]])))
    return slice(first, last)


def _plots(outcome: Outcome) -> list[rrb.TimeSeriesView | rrb.Grid]:
    time_s = outcome.recording.time_s

    def view(name: str, *contents: str) -> rrb.TimeSeriesView:
        return time_view(name, time_s, *contents)

    residuals = [view(f"{n}: corrected − truth (nT)", f"residual/{entity_name(n)}") for n in outcome.shown()]
    effects = [view(f"{n} (nT)", f"effects/{entity_name(n)}") for n in outcome.effects]
    return [
        *_grid("Residuals", residuals),
        view("Strength (nT)", "norm/**"),
        view("Measured field (nT)", "mag"),
        *_grid("Effects", effects),
        *_grid("Vehicle data", [view("Motor current (A)", "current"), view("Temperature (°C)", "temperature")]),
    ]


def _grid(name: str, views: list[rrb.TimeSeriesView]) -> list[rrb.Grid]:
    """Return a grid of views in a list; an empty list for no views."""
    return [rrb.Grid(*views, grid_columns=round(len(views) ** 0.5), name=name)] if views else []
