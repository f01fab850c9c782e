"""Magnetometers of the field's strength alone: optically pumped, Overhauser."""

from __future__ import annotations

from sim.sensors.base import Sensor
from sim.sensors.figures import full_scale, noise_density, offset, resolution, within

G_882 = Sensor(
    name="g_882",
    summary="Geometrics G-882, caesium vapour, marine; gives the field's strength",
    document="Geometrics, G-882 marine magnetometer, specification sheet",
    figures=(
        full_scale("100000 nT", 100_000.0, compared=False),
        noise_density("0.004 nT/√Hz", 0.004),
        offset("< 2 nT absolute accuracy", within(2.0)),
    ),
    left_out="heading error (< 1 nT) and dead zones, which have no model here; resolution",
    fastest_hz=20.0,
    scalar=True,
)

GSM_19 = Sensor(
    name="gsm_19",
    summary="GEM GSM-19, Overhauser; gives the field's strength",
    document="GEM Systems, GSM-19 v7.0 instruction manual, release 7.4",
    figures=(
        full_scale("120000 nT", 120_000.0, compared=False),
        noise_density("0.022 nT/√Hz", 0.022),
        resolution("0.01 nT", 0.01),
        offset("±0.1 nT absolute accuracy", within(0.1)),
    ),
    left_out="gradient tolerance, dead zones",
    fastest_hz=5.0,
    scalar=True,
)
