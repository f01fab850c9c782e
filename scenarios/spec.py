"""The part of a scenario that needs no simulator: frozen, strictly checked tables of a TOML file."""

from __future__ import annotations

import datetime
from typing import Annotated, Self

from pydantic import Field, model_validator

from scenarios.paths import Phase
from scenarios.table import Table
from scenarios.varied import Vary

FieldStrength = Annotated[float, Field(ge=-1e6, le=1e6)]
DIALECT = "https://json-schema.org/draft/2020-12/schema"
"""The version of JSON Schema of all schemas of magbench."""
MAX_SEED = 2**63 - 1
MAX_DURATION_S = 864_000
"""Ten days."""


class FieldSpec(Table):
    """Earth's field: by place and date (IGRF-14), or as a given vector."""

    latitude_deg: float | None = Field(None, ge=-90, le=90)
    longitude_deg: float | None = Field(None, ge=-180, le=360)
    altitude_m: float = Field(0.0, ge=-12_000, le=600_000)
    date: datetime.date | None = None
    enu_nT: tuple[FieldStrength, FieldStrength, FieldStrength] | None = Field(None, description="east, north, up")

    @model_validator(mode="after")
    def _one_of_two(self) -> FieldSpec:
        place = (self.latitude_deg, self.longitude_deg, self.date)
        if (self.enu_nT is None) == all(v is None for v in place):
            raise ValueError("give either enu_nT, or latitude_deg, longitude_deg and date")
        if self.enu_nT is None and any(v is None for v in place):
            raise ValueError("latitude_deg, longitude_deg and date go together")
        return self


class ThermalSpec(Table):
    """Sensor temperature: first-order lag behind the surroundings and the motors' heat.

    tau dT/dt = T_env(z) + heating_K_W P - T,  T_env = deep + (surface - deep) exp(z / scale_depth_m), z <= 0.
    """

    surface_degC: float = Field(20.0, ge=-60, le=80)
    deep_degC: float = Field(2.0, ge=-60, le=80)
    scale_depth_m: float = Field(500.0, gt=0)
    initial_degC: float | None = Field(None, ge=-60, le=120, description="default: in balance with the surroundings")
    heating_K_W: float = Field(0.02, ge=0, le=100)
    time_constant_s: float = Field(300.0, gt=0)


class SamplingSpec(Table):
    """The sensors' sample rate; a whole number of physics steps (50 Hz) a sample."""

    rate_hz: float = Field(10.0, ge=0.01, le=50)

    @model_validator(mode="after")
    def _whole_steps(self) -> SamplingSpec:
        if abs(50.0 / self.rate_hz - round(50.0 / self.rate_hz)) > 1e-9:
            raise ValueError("rate_hz must divide 50: 50, 25, 10, 5, 2, 1, 0.5, ...")
        return self


class NavigationSpec(Table):
    """Errors of all instruments but the magnetometer; white noise is per sample."""

    gyro_noise_std_rad_s: float = Field(1e-3, ge=0, le=10)
    gyro_bias_std_rad_s: float = Field(1e-4, ge=0, le=10, description="constant in a run, drawn once")
    accel_noise_std_m_s2: float = Field(0.02, ge=0, le=100)
    accel_bias_std_m_s2: float = Field(0.01, ge=0, le=100)
    attitude_noise_std_deg: float = Field(0.02, ge=0, le=180)
    attitude_correlation_s: float = Field(60.0, gt=0, description="first-order Gauss-Markov")
    attitude_delay_s: float = Field(0.0, ge=0, le=10, description="the attitude of a row is that of so long before")
    position_noise_std_m: float = Field(0.2, ge=0, le=1e6)
    position_correlation_s: float = Field(60.0, gt=0)
    temperature_noise_std_K: float = Field(0.01, ge=0, le=100)
    current_noise_std_A: float = Field(0.01, ge=0, le=1000)


class BaseScenario(Table):
    """A scenario's name, field, motion and instruments.

    The simulator's scenario adds the vehicle, the sensors and the effects.
    """

    name: str = Field(pattern=r"^[a-z0-9][a-z0-9_-]*$")
    summary: str
    seed: int = Field(0, ge=0, le=MAX_SEED)
    field: FieldSpec
    phases: tuple[Phase, ...] = Field(min_length=1)
    sampling: SamplingSpec = SamplingSpec()
    thermal: ThermalSpec = ThermalSpec()
    navigation: NavigationSpec = NavigationSpec()
    vary: dict[str, Vary] = Field(default_factory=dict, description="dotted key -> distribution")
    calibrators: tuple[str, ...] = ("sphere", "ellipsoid", "vector_least_squares")

    @model_validator(mode="after")
    def _ends(self) -> Self:
        total_s = sum(phase.duration_s for phase in self.phases)
        if total_s > MAX_DURATION_S:
            raise ValueError(f"the phases last {total_s:g} s together, at most {MAX_DURATION_S} s can be simulated")
        return self
