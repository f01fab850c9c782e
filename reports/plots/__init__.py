"""Plots of results, drawn with matplotlib: each function takes a result and returns a figure."""
