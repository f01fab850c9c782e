"""Inspection of a recording: contents, faults, and the calibrations that the data suffice for."""
