"""The mold in CadQuery: parting, features, undercuts, files."""
