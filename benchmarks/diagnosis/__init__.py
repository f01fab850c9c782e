"""The diagnosis against what is known to be hidden: recordings of MuJoCo motion, each with its truth.

Truth has another form than the candidate where one is at hand: eddy currents of a finite time constant, hysteresis of
several plays, two dipoles, a temperature felt through two lags, further harmonics, several thrusters. `wide` draws
motions, forms, noises and faults afresh for every seed, and takes the rests of measured logs for nulls.
"""
