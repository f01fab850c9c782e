"""Advice on the next flight: the leg that best distinguishes a named effect from its look-alikes."""
