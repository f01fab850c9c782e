"""Screening of a recording: faults of the sensor are named, and left out or mended before a fit."""
