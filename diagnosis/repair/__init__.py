"""Repair of the model: refined effects, the remaining gap, and the new model."""
