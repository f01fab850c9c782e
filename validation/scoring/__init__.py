"""How good a calibration is: hold-out motions, scores, and what a scenario gave."""
