"""Recordings for the rerun viewer: of a run here, of a diagnosis in `reports.viewer.diagnosis`."""

from reports.viewer.outcome import DRAWN, FULL, Detail, write_recording
from reports.viewer.rrd_file import read_series, verify, viewer_program

__all__ = ["DRAWN", "FULL", "Detail", "read_series", "verify", "viewer_program", "write_recording"]
