"""Functional mock-up units, FMI 2.0 for co-simulation: the regulator, and a finger as its plant."""
