"""Which manoeuvre a vehicle should fly to be calibrated: the shortest that is good enough, or the next leg."""
