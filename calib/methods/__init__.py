"""The calibration methods, one file each; the table is in `calib`."""
