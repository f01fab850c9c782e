"""Reproduction of [Long2013]: maximum-likelihood ellipsoid by Newton's method."""
