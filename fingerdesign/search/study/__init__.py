"""A study file: keys that vary, sampling, variants, their files."""
