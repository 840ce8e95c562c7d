"""Searching for better fingers: trials, confirmation, sensitivities, page."""
