"""Comparing fingers on one page: facts, front, table, views."""
