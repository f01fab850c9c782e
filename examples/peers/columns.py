"""A recording's columns and a calibration's file, for programs that use numpy alone."""

import json
import os
import sys

import numpy as np

STRENGTH_NT = float(os.environ.get("MAGBENCH_FIELD_STRENGTH_NT", "nan"))


def read(path):
    """Field, nT, and body rate, rad/s, both (n, 3) and forward, left, up; time (n,), s. No rate: None."""
    with open(path, encoding="utf-8") as file:
        names = file.readline().strip().split(",")
    mag = [f"mag_{axis}_nT" for axis in "xyz"]
    gyro = [f"gyro_{axis}_rad_s" for axis in "xyz"]
    wanted = ["time_s", *mag, *(gyro if gyro[0] in names else ())]
    places = [names.index(name) for name in wanted]
    rows = np.loadtxt(path, delimiter=",", skiprows=1, usecols=places, ndmin=2)
    return rows[:, 1:4], rows[:, 4:] if rows.shape[1] > 4 else None, rows[:, 0]


def write(path, offset_nT, matrix):
    """Write a calibration, h = matrix (m - offset)."""
    result = {"offset_nT": np.ravel(offset_nT).tolist(), "matrix": np.asarray(matrix).tolist()}
    with open(path, "w", encoding="utf-8") as file:
        json.dump(result, file)


def scaled(offset_nT, matrix, mag_nT):
    """The matrix with the length of the field that is known; for methods that find a matrix but for its scale."""
    length_nT = np.linalg.norm((mag_nT - np.ravel(offset_nT)) @ np.asarray(matrix).T, axis=1)
    return np.asarray(matrix) * STRENGTH_NT / length_nT.mean()


def main(methods):
    """METHOD RECORDING.csv RESULT.json: the method is (field, rate, time) -> (offset_nT, matrix)."""
    name, recording, result = sys.argv[1:]
    write(result, *methods[name](*read(recording)))
