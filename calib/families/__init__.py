"""Bases of methods that share a model: from a search over a population, of whole arrays, of filters."""
