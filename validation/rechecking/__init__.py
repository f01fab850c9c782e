"""Whether an old calibration still holds for the instrument that wrote a new log."""
