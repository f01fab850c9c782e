"""What the methods fit: the measurement models, their costs, derivatives and covariances."""
