"""Planning of calibration manoeuvres: the shortest manoeuvre for a target error, and next legs after a recording."""
