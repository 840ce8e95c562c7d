"""Molds: the parts that a finger is cast in, and whether they can be made."""
