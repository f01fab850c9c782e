"""What a command leaves in its directory: numbers, page and recording."""
