"""Signorini and Coulomb: laws, increments, force control, the certificate (numpy alone)."""
