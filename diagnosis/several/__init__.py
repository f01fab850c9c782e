"""Diagnosis of several recordings of one instrument: common effects, and effects that differ between recordings."""
