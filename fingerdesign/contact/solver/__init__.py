"""Solvers of one increment: tracking, Newton, complementary pivots, Gauss-Seidel."""
