"""Molds: the parts that a finger is cast in, what holds its plates, and whether they can be made."""
