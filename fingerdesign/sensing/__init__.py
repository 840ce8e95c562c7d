"""What gages tell: grip paths, teaching, observability."""
