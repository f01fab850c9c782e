"""Cramer-Rao bound of a calibration, and directions that a motion leaves unobservable."""
