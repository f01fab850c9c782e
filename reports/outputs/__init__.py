"""Files of each command's output directory: numbers, page and recording."""
