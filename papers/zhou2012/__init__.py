"""Reproduction of [Zhou2012]: five direction cosines from a turn about the vertical."""
