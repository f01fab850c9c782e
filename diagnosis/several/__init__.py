"""Several recordings of one instrument: what holds in all of them with one coefficient, and what does not."""
