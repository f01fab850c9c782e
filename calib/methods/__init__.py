"""The calibration methods, one file each; the list of them is in `calib`."""
