"""The version, for whatever is kept or written by it."""

__version__ = "0.1.0"
