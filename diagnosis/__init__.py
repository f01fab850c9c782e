"""Diagnosis of the gap between a recording and a model: missing effects, and the model including them."""
