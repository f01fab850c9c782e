"""Magnetic bodies near the path: wrecks and ordnance as dipoles, pipelines as long thin magnets."""

from __future__ import annotations

import math
from typing import Annotated

import numpy as np

from scenarios.arrays import Array
from scenarios.errors import InputError
from sim.effects.base import ZERO3, Effect, Memory, array, frozen
from sim.effects.kernels import kernel
from sim.effects.parameters import Quantity, Vec3
from sim.effects.traits import THE_TRACK_AGAIN, Traits
from sim.rotation import to_body
from sim.state import State

MU0_4PI_nT = 100.0
"""mu_0 / (4 pi) in nT m^3 / (A m^2)."""


@frozen
class LocalDipole(Effect):
    """Field of a fixed magnetic body: a dipole, or with an extent a thin cylinder of uniform magnetisation.

    ``B = mu_0/(4 pi) R_wb^T (3 (m.r) r / r^5 - m / r^3)``, r from the body to the sensor. The cylinder runs from
    `position` to `position + extent`; the moment m, in any direction, is spread evenly along the cylinder, and B is the
    integral of the dipole's field in closed form.

    Raises InputError where the sensor goes through the body.
    """

    name = "local_dipole"
    stage = "field"
    needs = ("attitude", "position")
    example = {
        "position_enu_m": (3.0, 2.0, -50.0),
        "moment_A_m2": (9e3, 2e3, -4e3),
        "extent_enu_m": (9.0, 80.0, 1.0),
    }
    traits = Traits(
        experiment=THE_TRACK_AGAIN, remedy="calibrate away from wrecks, pipelines and steel", field_source=True
    )

    position_enu_m: Annotated[
        Vec3, Quantity("m", -1e7, 1e7, "where it lies, or where the cylinder begins", role="place")
    ] = ZERO3
    moment_A_m2: Annotated[Vec3, Quantity("A m^2", -1e9, 1e9, "total moment east, north, up", role="linear")] = ZERO3
    extent_enu_m: Annotated[
        Vec3, Quantity("m", -1e5, 1e5, "from the cylinder's begin to its end; zero: a dipole", role="fixed")
    ] = ZERO3

    def apply(self, state: State, signal_nT: Array, rng: np.random.Generator, memory: Memory) -> Array:
        way = state.pos_enu_m - array(self.position_enu_m)
        moment, extent = array(self.moment_A_m2), array(self.extent_enu_m)
        world = line_field_nT(way, moment, extent) if extent.any() else dipole_field_nT(way, moment)
        if not np.isfinite(world).all():
            raise InputError(
                f"the sensor goes through the source at {self.position_enu_m} m, where its field is infinite",
                where="effects.local_dipole.position_enu_m",
                do="move the source or the path",
            )
        return np.asarray(to_body(state.R_wb, world))


def dipole_field_nT(way_m: Array, moment_A_m2: Array) -> Array:
    """Field (n, 3) in nT of a dipole at the origin, at way_m (n, 3)."""
    return _dipole_field(way_m, MU0_4PI_nT * moment_A_m2)


@kernel
def _dipole_field(way: Array, moment: Array) -> Array:
    """3 (m.u) u / r^3 - m / r^3, u = R / r: free of overflow also close to a body."""
    field = np.empty((len(way), 3))
    for i in range(len(way)):
        r = math.sqrt(way[i, 0] ** 2 + way[i, 1] ** 2 + way[i, 2] ** 2)
        ux, uy, uz = way[i, 0] / r, way[i, 1] / r, way[i, 2] / r
        along = 3.0 * (moment[0] * ux + moment[1] * uy + moment[2] * uz)
        field[i, 0] = (along * ux - moment[0]) / r / r / r
        field[i, 1] = (along * uy - moment[1]) / r / r / r
        field[i, 2] = (along * uz - moment[2]) / r / r / r
    return field


def line_field_nT(way_m: Array, moment_A_m2: Array, extent_m: Array) -> Array:
    """Field (n, 3) in nT, at way_m (n, 3), of a moment spread evenly along the line from the origin to extent_m."""
    length = math.hypot(*extent_m)
    return _line_field(way_m, MU0_4PI_nT / length * moment_A_m2, extent_m / length, length)


@kernel
def _line_field(way: Array, density: Array, axis: Array, length: float) -> Array:
    """Integral of 3 (d.R) R / R^5 - d / R^3 along the line, R = across + t axis, t from z - length to z.

    With r_i the distance to an end and a_i = t_i / r_i: int 1/R^3 = (a_2 - a_1) / across^2 = J,
    int t^2/R^5 = J (a_1^2 + a_1 a_2 + a_2^2) / 3, int t/R^5 = (r_1^-3 - r_2^-3) / 3.
    """
    field = np.empty((len(way), 3))
    along_density = density[0] * axis[0] + density[1] * axis[1] + density[2] * axis[2]
    for i in range(len(way)):
        high = way[i, 0] * axis[0] + way[i, 1] * axis[1] + way[i, 2] * axis[2]
        low = high - length
        ax, ay, az = way[i, 0] - high * axis[0], way[i, 1] - high * axis[1], way[i, 2] - high * axis[2]
        across2 = ax * ax + ay * ay + az * az
        r1, r2 = math.sqrt(across2 + low * low), math.sqrt(across2 + high * high)
        a1, a2 = low / r1, high / r2
        # Beyond an end the difference a2 - a1 would cancel, so there it is taken in another form.
        beyond = low * high > 0.0
        J = (high * high - low * low) / ((high * r1 + low * r2) * r1 * r2) if beyond else (a2 - a1) / across2
        squares = (a1 * a1 + a1 * a2 + a2 * a2) / 3.0
        odd = (1.0 / r1**3 - 1.0 / r2**3) / 3.0
        across_density = density[0] * ax + density[1] * ay + density[2] * az
        round_part = across_density * J * (1.0 - squares) / across2 if across2 > 0.0 else 0.0
        on_across = 3.0 * (round_part + along_density * odd)
        on_axis = 3.0 * (across_density * odd + along_density * J * squares)
        field[i, 0] = on_across * ax + on_axis * axis[0] - density[0] * J
        field[i, 1] = on_across * ay + on_axis * axis[1] - density[1] * J
        field[i, 2] = on_across * az + on_axis * axis[2] - density[2] * J
    return field
