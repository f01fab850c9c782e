"""The table of sensors for scenarios.

To add a sensor: the data sheet as a `Sensor` in a file of this package, and a line in SENSORS.
"""

from __future__ import annotations

from typing import Annotated

from pydantic import AfterValidator, WithJsonSchema

from scenarios.names import closest
from scenarios.problems import misfit
from sim.sensors.base import DatasheetFigure, Sensor
from sim.sensors.chips import AK09916, BMM350, HMC5883L, IST8310, LIS3MDL, RM3100
from sim.sensors.fluxgates import FLC3_70, MAG_03
from sim.sensors.scalars import G_882, GSM_19

SENSORS: dict[str, Sensor] = {
    sensor.name: sensor
    for sensor in (
        MAG_03,
        FLC3_70,
        RM3100,
        BMM350,
        IST8310,
        LIS3MDL,
        AK09916,
        HMC5883L,
        G_882,
        GSM_19,
    )
}
"""Every sensor by name."""


def _known(name: str) -> str:
    if name not in SENSORS:
        raise misfit((), f"no sensor {name!r}", closest(name, SENSORS, most=len(SENSORS)))
    return name


SensorName = Annotated[str, AfterValidator(_known), WithJsonSchema({"type": "string", "enum": list(SENSORS)})]

__all__ = ["SENSORS", "DatasheetFigure", "Sensor", "SensorName"]
