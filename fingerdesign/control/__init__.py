"""Grips: episode, metrics, estimator, signals (numpy alone)."""
