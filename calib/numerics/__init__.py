"""Numerical parts that know nothing of calibration: rates, colour of noise, fuzzy rules, compiled loops."""
