"""Decisions: from evidence to accepted effects and a verdict."""
