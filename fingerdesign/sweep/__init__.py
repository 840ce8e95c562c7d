"""Studies of many fingers: variants, their outcomes, optimisation, comparison."""
