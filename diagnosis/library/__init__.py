"""What may be missing, as columns of the linear problem, and the searches for what no list can hold."""
