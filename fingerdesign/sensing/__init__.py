"""Training of the estimator, identification of hidden values, perturbed fingers."""
