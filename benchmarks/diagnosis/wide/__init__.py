"""Truths that no candidate has the form of: motions, forms, filters, noises and faults drawn afresh for every seed.

Nothing here uses the simulator's magnetometer chain or the diagnosis' candidates: a form is a function of the course.
"""
