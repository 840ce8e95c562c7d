"""Recordings of slip that others measured, and our detectors on them."""
