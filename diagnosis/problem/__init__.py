"""A recording compared with a model: a linear problem, cut into blocks."""
