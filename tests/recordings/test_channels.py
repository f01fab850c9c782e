"""Which channels of an autopilot's log may be a cause of a disturbance."""

from __future__ import annotations

import pytest

from recordings.channels import REFERENCE, SCALAR, may_be_cause

CAUSES = (
    *("throttle", "wheel_rad_s", "current_2_A", "temperature_degC", "battery_voltage_V", "motor_output_3"),
    *("BAT.Curr", "BAT[1].Volt", "RCOU.C3", "CTUN.ThO", "IMU.T", "PIDR.Tar", "ESC[2].RPM", "battery_status.current_a"),
    *("vehicle_air_data.baro_pressure_pa", "actuator_outputs.output[3]", "esc_status.esc[0].esc_rpm", "depth_m"),
    *("landing_gear.landing_gear", "magnet_heater_A", "image_rate_hz", SCALAR, *REFERENCE),
)
NO_CAUSES = (
    *("vehicle_gps_position.time_utc_usec", "telemetry_status[3].tx_message_count", "MAG[1].MagX", "sensor_mag.x"),
    *("estimator_innovation_variances.gps_vvel", "estimator_states.covariances[12]", "XKF3.IVN", "NKF1.Roll"),
    *("vehicle_magnetometer.magnetometer_ga[0]", "vehicle_local_position.xy_reset_counter", "GPS.GWk_timestamp"),
    *("sensor_combined.magnetometer_timestamp_relative", "compass_health", "magADC[2]", "mag_field_x", "imu.seq"),
)


@pytest.mark.parametrize("name", CAUSES)
def test_what_the_vehicle_does_may_be_a_cause(name: str) -> None:
    assert may_be_cause(name)


@pytest.mark.parametrize("name", NO_CAUSES)
def test_clocks_estimators_and_magnetometers_are_no_cause(name: str) -> None:
    assert not may_be_cause(name)
