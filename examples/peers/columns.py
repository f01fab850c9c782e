"""A recording's columns and a calibration's file, for programs that use numpy alone."""

import json
import os
import sys

import numpy as np

STRENGTH_NT = float(os.environ.get("MAGBENCH_FIELD_STRENGTH_NT", "nan"))


def read(path):
    """Field, nT, and body rate, rad/s, both (n, 3) and forward, left, up; time (n,), s. No rate: None."""
    rows = columns(path, "mag_{}_nT"), columns(path, "gyro_{}_rad_s"), columns(path, "time_s", axes=" ")
    return rows[0], rows[1], rows[2][:, 0]


def force(path):
    """Specific force, m/s^2, (n, 3), forward, left, up."""
    return columns(path, "accel_{}_m_s2")


def columns(path, name, axes="xyz"):
    """A quantity's columns (n, axes); None where they are not there."""
    with open(path, encoding="utf-8") as file:
        names = file.readline().strip().split(",")
    wanted = [name.format(axis) for axis in axes]
    if wanted[0] not in names:
        return None
    places = [names.index(one) for one in wanted]
    return np.loadtxt(path, delimiter=",", skiprows=1, usecols=places, ndmin=2)


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
