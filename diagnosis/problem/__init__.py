"""A recording beside a model, as a linear problem cut into blocks."""
