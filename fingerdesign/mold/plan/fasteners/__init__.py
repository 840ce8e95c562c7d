"""Bolts, pins and core pins: their columns, places, and what keeps them from fitting."""
