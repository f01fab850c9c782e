"""Vehicles in MuJoCo: a file each, and a line in VEHICLES."""

from __future__ import annotations

from functools import reduce
from operator import or_
from typing import TYPE_CHECKING, Annotated

from pydantic import Field

from scenarios.paths.base import PhaseBase
from sim.vehicles.auv import Auv
from sim.vehicles.base import Vehicle, VehicleTable
from sim.vehicles.quadrotor import Quadrotor
from sim.vehicles.turntable import Turntable

VEHICLES: dict[str, type[Vehicle]] = {
    cls.name: cls
    for cls in (
        Auv,
        Quadrotor,
        Turntable,
    )
}

if TYPE_CHECKING:
    VehicleSpec = VehicleTable
else:
    VehicleSpec = Annotated[reduce(or_, (cls.table for cls in VEHICLES.values())), Field(discriminator="kind")]
"""The `vehicle` table of a scenario: that of any vehicle here, told by its kind."""


def vehicles_for(phase: PhaseBase | type[PhaseBase]) -> list[str]:
    """Names of the vehicles able to do a phase."""
    return [name for name, cls in VEHICLES.items() if cls.can(phase)]


def vehicle_for(spec: VehicleTable) -> Vehicle:
    """The vehicle of a scenario's vehicle table."""
    return VEHICLES[spec.kind](spec)
