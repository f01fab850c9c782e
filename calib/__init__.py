"""Calibrators: one file each, a base class and the result type."""
