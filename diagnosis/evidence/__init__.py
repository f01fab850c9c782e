"""What the data say of a candidate: numbers, no verdicts."""
