"""Results in words and rows, which pages, recordings and the terminal share."""
