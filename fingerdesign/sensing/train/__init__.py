"""Training of the estimator of the stick ratio."""
