"""Recordings for the rerun viewer: of a run here, of a diagnosis in `reports.viewer.diagnosis`."""

from reports.viewer.outcome import write_recording
from reports.viewer.rrd_file import read_series, verify, viewer_program

__all__ = ["read_series", "verify", "viewer_program", "write_recording"]
