"""What accuracy is possible: the Cramer-Rao bound of a calibration, and what the motion cannot tell."""
