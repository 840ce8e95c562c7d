"""Fingers as they are cast: what tolerances do to forces, stick ratio and gages."""
