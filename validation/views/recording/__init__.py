"""Recordings for the rerun viewer: of an outcome here, of a diagnosis in `validation.views.recording.diagnosis`."""

from validation.views.recording.outcome import write_recording
from validation.views.recording.reading import read_series, verify, viewer_program

__all__ = ["read_series", "verify", "viewer_program", "write_recording"]
