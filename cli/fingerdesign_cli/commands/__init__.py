"""The commands as click sees them: names, options and help; no work."""
