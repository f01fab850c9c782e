"""Reproduction of [Zhang2018]: spiral of an AUV; ellipsoid, PSO, GA and PSOGA."""
