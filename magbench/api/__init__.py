"""The public functions, one a file; commands call them and print the result. Each imports its packages when called."""
