"""Results as one HTML page each."""
