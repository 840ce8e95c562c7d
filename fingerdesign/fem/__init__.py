"""Elasticity on quadratic elements: assembly, condensation, sheets, readouts."""
