"""Searches over a population: one loop, and the moves that plug into it."""
