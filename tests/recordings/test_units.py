"""The units of a measured log against scipy's constants."""

from __future__ import annotations

import numpy as np
import pytest
from scipy import constants

from recordings.units import UNITS

SI = {
    "time": {"s": 1.0, "ms": constants.milli, "us": constants.micro, "ns": constants.nano, "min": constants.minute},
    "mag": {
        **{"pT": constants.pico, "nT": constants.nano, "uT": constants.micro, "mT": constants.milli, "T": 1.0},
        **{"G": 1e-4, "gauss": 1e-4, "mG": 1e-7},
    },
    "gyro": {
        **{"rad/s": 1.0, "rad_s": 1.0, "mrad/s": constants.milli},
        **dict.fromkeys(("deg/s", "deg_s", "dps"), constants.degree),
    },
    "accel": {**dict.fromkeys(("m/s^2", "m_s2", "m/s2"), 1.0), "g": constants.g, "mg": constants.milli * constants.g},
    "position": {
        **{"m": 1.0, "cm": constants.centi, "mm": constants.milli, "km": constants.kilo, "ft": constants.foot}
    },
    "current": {"A": 1.0, "mA": constants.milli},
}
OWN = {"mag": constants.nano}
"""What a column's own unit is in SI units, where it is none itself."""


@pytest.mark.parametrize("kind", SI)
def test_factors_are_those_of_the_unit(kind: str) -> None:
    factors = {unit: factor * OWN.get(kind, 1.0) for unit, (factor, offset) in UNITS[kind].items() if offset == 0.0}
    assert factors == pytest.approx(SI[kind], rel=1e-15)


@pytest.mark.parametrize(("unit", "scale"), [("degC", "Celsius"), ("K", "Kelvin"), ("degF", "Fahrenheit")])
def test_temperatures_are_those_of_the_scale(unit: str, scale: str) -> None:
    factor, offset = UNITS["temperature"][unit]
    values = np.array([-10.0, 0.0, 25.0, 300.0])
    expected = constants.convert_temperature(values, scale, "Celsius")
    np.testing.assert_allclose(factor * values + offset, expected, rtol=0, atol=1e-10)


def test_every_unit_is_compared() -> None:
    assert UNITS.keys() - SI.keys() == {"temperature"}
