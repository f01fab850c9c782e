"""Trials and rows of [Ding2021]'s other arrangements: error of the differences near a dipole, noise, calibration."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from calib.methods.least_squares_gradiometer import LeastSquaresGradiometer
from calib.models.sensor_array import PER_SENSOR
from papers.base import PaperRow, spread_text
from papers.ding2021.geometry import ARRANGEMENTS, CROSS, operator, places, reach, tensors
from papers.ding2021.trials import BASELINE_M, REFERENCE, STRENGTH_NT, simulate
from papers.judgement import claim, incomparable
from scenarios.arrays import Array
from scenarios.seeds import stream
from sim.effects.sources import dipole_field_nT
from validation.signals.amplitude import rms
from validation.text import figure

DISTANCES_M = (1.0, 2.0, 4.0)
DIPOLES, MOMENT_A_M2 = 2000, 10.0
POINT = 1e-3
"""Size of an array so small that its differences are the derivatives: errors of a millionth of the full size's."""
LEAST = 0.9
"""Ratio to the next arrangement below which an arrangement has the least error: 2000 dipoles scatter by 1 %."""
CASE, NOISE_NT = 2, 10.0


def dipole_error(place_m: Array, distance_m: float) -> float:
    """Return the rms error of G's components over their rms, without noise, for dipoles of random place and moment."""
    draw = stream(2021, 0, "dipoles")
    way, moment = (_directions(draw) for _ in range(2))
    exact, found = (
        tensors(size * place_m, np.array([_dipole_nT(size * r - distance_m * way, moment) for r in place_m]))
        for size in (POINT, 1.0)
    )
    return float(np.sqrt(np.mean((found - exact) ** 2) / np.mean(exact**2)))


def passed_on(place_m: Array) -> float:
    """Return the rms over the components of G, 1/m, that white noise of unit deviation on every axis leaves."""
    return float(np.sqrt(np.sum(operator(place_m) ** 2) / 5))


def _directions(draw: np.random.Generator) -> Array:
    vectors = draw.standard_normal((DIPOLES, 3))
    return np.asarray(vectors / np.linalg.norm(vectors, axis=1)[:, None])


def _dipole_nT(way_m: Array, moment: Array) -> Array:
    """Return the fields (n, 3) of dipoles with moments (n, 3) at ways (n, 3): linear in the moment."""
    units = [dipole_field_nT(way_m, MOMENT_A_M2 * axis) for axis in np.eye(3)]
    return np.asarray(sum(moment[:, [k]] * unit for k, unit in enumerate(units)))


@dataclass(frozen=True)
class GeometryTrial:
    """Results of a seed in simulation 2 with 10 nT: rms of the tensor's components after calibration, nT/m, by name.

    offset_nT: largest error of an offset, by number of sensors.
    """

    tensor_nT_m: dict[str, float]
    offset_nT: dict[int, float]


def geometry_trial(seed: int) -> GeometryTrial:
    """Calibrate four sensors and three in a uniform field, and take each arrangement's tensor of what is left.

    The objective without its tensor terms, which belong to the cross.
    """
    array = simulate(CASE, NOISE_NT, seed)
    truth = array.parameters.reshape(-1, PER_SENSOR)[:, :3] * STRENGTH_NT
    left, error = {}, {}
    for k in (3, 4):
        assert array.recording.array_mag_nT is not None
        array_nT = array.recording.array_mag_nT[:k]
        part = replace(array.recording, array_mag_nT=array_nT)
        fit = LeastSquaresGradiometer(start="two_step", tensor=0.0).fit(part, REFERENCE)
        assert fit.array_matrix is not None
        assert fit.array_offset_nT is not None
        error[k] = float(np.abs(fit.array_offset_nT - truth[:k]).max())
        field = np.einsum("kij,knj->kni", fit.array_matrix, array_nT - fit.array_offset_nT[:, None])
        for name in (name for name, place in ARRANGEMENTS.items() if len(place) == k):
            left[name] = rms(tensors(BASELINE_M * places(name), field))
    return GeometryTrial(left, error)


def geometry_rows(trials: list[GeometryTrial]) -> list[PaperRow]:
    """Return the rows on the error of the differences by arrangement, at one baseline and at one size, and on noise."""
    one = {name: BASELINE_M * places(name) for name in ARRANGEMENTS}
    other = {name: place * reach(CROSS) / reach(name) for name, place in one.items()}
    return [
        _differences(one, f"baseline {BASELINE_M:g} m", "sides, legs and edges as long as the cross's baseline"),
        _differences(
            other,
            f"sensors within {BASELINE_M / 2:g} m of the centre",
            "there the square is the cross turned by 45 degrees",
        ),
        _noise(trials),
    ]


def _differences(arrangements: dict[str, Array], size: str, what: str) -> PaperRow:
    error = {name: [dipole_error(place, r) for r in DISTANCES_M] for name, place in arrangements.items()}
    cross = error.pop(CROSS)
    least = np.min(list(error.values()), axis=0)
    listed = "; ".join(
        f"{name} {', '.join(figure(100 * e) for e in errors)}" for name, errors in {CROSS: cross, **error}.items()
    )
    return PaperRow(
        f"error of the differences without noise, dipole at {', '.join(f'{r:g}' for r in DISTANCES_M)} m, {size}",
        "the cross has the least error of five arrangements (no figure)",
        f"{listed} % of the tensor",
        claim(
            np.all(np.array(cross) < LEAST * least),
            f"below {LEAST:g} times the next at every distance",
            "least has no number; a tenth is beyond the scatter of 2000 dipoles",
        ),
        f"{what}; tensor by least squares of all sensors at their centre, rms over {DIPOLES} dipoles of random place "
        "and moment. Cross and square lie evenly about their centre, so that errors fall with the square of size over "
        "distance; those of the others with the ratio itself",
    )


def _noise(trials: list[GeometryTrial]) -> PaperRow:
    left = {name: [t.tensor_nT_m[name] for t in trials] for name in ARRANGEMENTS}
    alone = {name: passed_on(BASELINE_M * places(name)) * NOISE_NT / np.sqrt(3.0) for name in left}
    offset = ", ".join(f"{k} sensors {spread_text([t.offset_nT[k] for t in trials], 'nT')}" for k in (3, 4))
    return PaperRow(
        f"other arrangements calibrated, simulation {CASE}, noise {NOISE_NT:g} nT: rms of the tensor, baseline "
        f"{BASELINE_M:g} m",
        "not tried",
        "; ".join(f"{name} {spread_text(values)}" for name, values in left.items()) + " nT/m",
        incomparable("the paper calibrates the cross alone"),
        "what the noise alone leaves: "
        + ", ".join(f"{name} {figure(value)}" for name, value in alone.items())
        + f" nT/m: at one baseline the cross passes on most. In a uniform field the places do not enter the "
        f"calibration: largest offset error {offset}",
    )
