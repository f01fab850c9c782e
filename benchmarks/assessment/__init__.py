"""The assessment of calibrations: whether intervals of the heading error hold, and answers to a tolerance."""
