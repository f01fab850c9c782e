"""Accuracy gates: does a calibrator keep its limit, decided trial by trial at a stated rate of false failures."""
