"""What to fly next: the leg that tells what was named from what looks like it."""
