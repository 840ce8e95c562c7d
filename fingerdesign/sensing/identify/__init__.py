"""Identification of hidden values from a trace or a bench: one inverse problem."""
