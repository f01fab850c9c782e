"""The report's pictures, each a function from an Outcome to a matplotlib figure."""
