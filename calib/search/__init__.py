"""Population searches: a common loop, and interchangeable moves."""
