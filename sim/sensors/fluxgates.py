"""Fluxgates."""

from __future__ import annotations

from sim.sensors.base import Sensor
from sim.sensors.figures import (
    bandwidth,
    full_scale,
    linearity,
    noise,
    noise_density,
    offset,
    offset_drift,
    orthogonality,
    sensitivity,
    within,
)

MAG_03 = Sensor(
    name="mag_03",
    summary="Bartington Mag-03, low-noise three-axis fluxgate of +-100 uT for surveys and observatories",
    document="Bartington Instruments, Mag-03 three-axis magnetic field sensors, data sheet",
    figures=(
        full_scale("±100 µT", 100_000.0),
        noise_density("6 pT/√Hz at 1 Hz (low noise), taken as white", 0.006),
        offset("±5 nT", within(5.0), compared=False),
        offset_drift("±0.1 nT/°C", within(0.1), compared=False),
        sensitivity("±0.5 %", within(0.005), compared=False),
        orthogonality("< 0.5°", within(0.5), compared=False),
        linearity("< 0.0015 %", 1.5e-5, 100_000.0, compared=False),
        bandwidth("0 to 3 kHz", 3000.0, compared=False),
    ),
    left_out="resolution (analogue output), sensitivity drift, noise below 1 Hz",
)

FLC3_70 = Sensor(
    name="flc3_70",
    summary="Stefan Mayer FLC3-70, small three-axis fluxgate of +-200 uT for drones",
    document="Stefan Mayer Instruments, FLC3-70 triaxial magnetic field sensor, data sheet",
    figures=(
        full_scale("±200 µT", 200_000.0),
        noise("< 0.5 nT rms", 0.5),
        offset("±0.5 µT", within(500.0), compared=False),
        offset_drift("< 2 nT/K", within(2.0), compared=False),
        sensitivity("±1 %", within(0.01), compared=False),
        orthogonality("< 1°", within(1.0), compared=False),
        bandwidth("1 kHz", 1000.0, compared=False),
    ),
    left_out="resolution (analogue output), sensitivity drift, linearity, hysteresis",
)
