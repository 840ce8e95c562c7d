"""Which model is fine enough: rungs, ladder, error estimates."""
