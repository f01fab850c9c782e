"""What to simulate: frozen scenario specs, reference paths, and the catalogue of named scenarios."""
