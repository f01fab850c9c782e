"""Honesty on disturbed logs: how often a calibration is confidently wrong, and how often the reason names why."""
