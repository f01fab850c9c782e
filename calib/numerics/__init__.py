"""Numerical methods without reference to calibration."""
