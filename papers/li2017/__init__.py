"""Reproduction of [Li2017]: 21 parameters with eddy currents by Kalman filters."""
