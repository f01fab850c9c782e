"""Judging calibrators against the truth: scores, report, recording."""
