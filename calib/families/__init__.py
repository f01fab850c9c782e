"""Base classes of methods with a common model."""
