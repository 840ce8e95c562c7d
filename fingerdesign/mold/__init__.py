"""Molds: the parts that a finger is cast in, what holds its plates, whether they can be made."""
