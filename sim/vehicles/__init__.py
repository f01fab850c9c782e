"""Vehicles in MuJoCo: one file each; a new one is a line in VEHICLES."""

from __future__ import annotations

from typing import Any

from sim.vehicles.auv import Auv
from sim.vehicles.base import Vehicle
from sim.vehicles.quadrotor import Quadrotor
from sim.vehicles.turntable import Turntable

VEHICLES: dict[str, type[Vehicle]] = {"auv": Auv, "quadrotor": Quadrotor, "turntable": Turntable}


def vehicle_for(spec: Any) -> Vehicle:
    """The vehicle of a scenario's vehicle table."""
    return VEHICLES[spec.kind](spec)
