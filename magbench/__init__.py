"""The face of the bench: command line and public names."""
