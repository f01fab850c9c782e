"""Axes of a magnetometer against the axes of gyro, accelerometer and attitude; frame of a log."""
