"""Calibrators on a recording: fitted, written, read again, exported."""
