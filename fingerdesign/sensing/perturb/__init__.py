"""Fingers and objects that came out different from their design (domain randomisation)."""
