"""Many trials of several calibrators: computed on any number of machines, kept as they land, put into one table."""
