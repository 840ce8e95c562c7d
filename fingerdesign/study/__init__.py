"""Searches over designs: what to vary, what to ask of each, which to keep."""
