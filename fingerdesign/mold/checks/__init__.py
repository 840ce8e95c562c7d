"""Checks of a built mold."""
