"""Reproduction of [Ding2021]: gradiometer of four sensors, 48 parameters."""
