"""Numbers that a series gives: noise, tones, value lattice, faults, conventions; no judgement."""
