"""Derivatives of forces, areas and readings, through the exact contact."""
