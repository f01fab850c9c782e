"""Statistics of candidates and residuals, computed from the data; verdicts are drawn in `decision`."""
