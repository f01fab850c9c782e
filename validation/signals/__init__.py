"""Estimates from time series: noise, tones, converter steps, faulty samples, conventions of quaternions."""
