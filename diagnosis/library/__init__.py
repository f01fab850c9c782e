"""Library of effects as columns of the linear problem, and searches for parameters without a list of values."""
