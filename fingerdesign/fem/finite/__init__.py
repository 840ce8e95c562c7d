"""Finite strain: elements, body, gages, one row of a path."""
