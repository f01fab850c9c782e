"""How good a calibration of a recording is: heading error with interval, held-out strength, verdict, tolerance."""
