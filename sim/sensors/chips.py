"""Magnetometers on a chip or a small board."""

from __future__ import annotations

from sim.sensors.base import Sensor
from sim.sensors.figures import (
    full_scale,
    hysteresis,
    linearity,
    noise,
    offset,
    resolution,
    sensitivity,
    sensitivity_drift,
    sensitivity_slope,
    typical,
    within,
)

GAUSS_NT = 100_000.0

RM3100 = Sensor(
    name="rm3100",
    summary="PNI RM3100, magneto-inductive, at 200 cycle counts",
    document="PNI Sensor, RM3100 & RM2100 sensor suite user manual, doc 1017252 R07, table 3-1",
    figures=(
        full_scale("±800 µT", 800_000.0),
        resolution("75 LSB/µT", 1000.0 / 75.0),
        noise("15 nT", 15.0),
        hysteresis("15 nT", 15.0),
        linearity("0.5 % over ±200 µT", 0.005, 200_000.0, compared=False),
    ),
    left_out="offset, sensitivity, their drifts, orthogonality, noise below the sample rate",
    fastest_hz=146.0,
)

BMM350 = Sensor(
    name="bmm350",
    summary="Bosch BMM350, tunnel-magnetoresistive, at 100 Hz with averaging of 2",
    document="Bosch Sensortec, BMM350 data sheet BST-BMM350-DS001 and product flyer",
    figures=(
        full_scale("±2000 µT", 2_000_000.0),
        resolution("0.1 µT", 100.0),
        noise("190 nT rms (x, y), 450 nT rms (z)", 190.0, 190.0, 450.0),
        offset("±25 µT typical, after soldering", typical(25_000.0)),
        sensitivity("±1 % typical, after soldering", typical(0.01)),
        sensitivity_drift("±0.010 %/K typical", typical(1e-4)),
    ),
    left_out="offset drift, orthogonality, linearity, hysteresis",
    fastest_hz=400.0,
)

IST8310 = Sensor(
    name="ist8310",
    summary="iSentek IST8310, magnetoresistive, of many autopilots",
    document="iSentek, IST8310 data sheet 1.2",
    figures=(full_scale("±1600 µT (x, y)", 1_600_000.0), resolution("0.3 µT/LSB", 300.0)),
    left_out="noise (no figure was at hand: at rest the rounding alone is left), offset, sensitivity, linearity",
    fastest_hz=200.0,
)

LIS3MDL = Sensor(
    name="lis3mdl",
    summary="ST LIS3MDL, magnetoresistive, ultra-high-performance mode at +-4 gauss",
    document="STMicroelectronics, LIS3MDL data sheet, DocID024204 Rev 6, table 3",
    figures=(
        full_scale("±4 gauss", 4 * GAUSS_NT),
        resolution("6842 LSB/gauss", GAUSS_NT / 6842.0),
        noise("3.2 mgauss rms (x, y), 4.1 mgauss rms (z)", 320.0, 320.0, 410.0),
        offset("±1 gauss typical", typical(GAUSS_NT)),
        linearity("±0.12 % of ±12 gauss", 0.0012, 12 * GAUSS_NT),
    ),
    left_out="offset drift (the sheet gives none), sensitivity, orthogonality, hysteresis",
    fastest_hz=155.0,
)

AK09916 = Sensor(
    name="ak09916",
    summary="AKM AK09916, Hall sensors with a concentrator, of many phones and inertial units",
    document="Asahi Kasei Microdevices, AK09916 data sheet 015007392-E-02",
    figures=(
        full_scale("±4912 µT", 4_912_000.0),
        resolution("0.15 µT/LSB", 150.0),
        sensitivity("0.1425 to 0.1575 µT/LSB", within(0.05), compared=False),
        offset("±2000 LSB", within(300_000.0), compared=False),
    ),
    left_out="noise (no figure was at hand: at rest the rounding alone is left), drifts, orthogonality, linearity",
    fastest_hz=100.0,
)

HMC5883L = Sensor(
    name="hmc5883l",
    summary="Honeywell HMC5883L, anisotropic magnetoresistive, at its default gain of +-1.3 gauss",
    document="Honeywell, HMC5883L 3-axis digital compass IC, form 900405",
    figures=(
        full_scale("2047 LSB at 1090 LSB/gauss", 2047.0 / 1090.0 * GAUSS_NT),
        resolution("1090 LSB/gauss", GAUSS_NT / 1090.0),
        noise("2 mgauss", 200.0),
        sensitivity("±5 %", within(0.05), compared=False),
        sensitivity_slope("-0.3 %/°C, uncompensated", -0.003, compared=False),
        linearity("0.1 % of ±2 gauss", 0.001, 2 * GAUSS_NT, compared=False),
        hysteresis("±25 ppm of ±2 gauss", 2 * 25e-6 * 2 * GAUSS_NT, compared=False),
    ),
    left_out="offset, its drift, orthogonality; the cross-axis effect (0.2 % of full scale a gauss) has no model here",
    fastest_hz=75.0,
)
